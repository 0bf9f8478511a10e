# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui import overlays, session
from ...ui.job_operator import JobOperator


class TRANSFORMABLES_OT_embed(JobOperator, bpy.types.Operator):
    """Search for a way to fold the skeleton into the target, and keep it for the stages below"""

    bl_idname = "transformables.embed"
    bl_label = "Find Folded Pose"
    bl_options = {"UNDO"}
    until = "embedding"


class TRANSFORMABLES_OT_hide_pose(bpy.types.Operator):
    """Stop drawing the folded skeleton in the 3D view. The pose that was found is kept"""

    bl_idname = "transformables.hide_pose"
    bl_label = "Hide Drawn Pose"

    @classmethod
    def poll(cls, context):
        if not overlays.shown():
            cls.poll_message_set("No pose is drawn")
            return False
        return True

    def execute(self, context):
        overlays.clear()
        session.redraw()
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_embed, TRANSFORMABLES_OT_hide_pose)
