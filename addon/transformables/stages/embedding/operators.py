# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui.job_operator import JobOperator


class TRANSFORMABLES_OT_embed(JobOperator, bpy.types.Operator):
    """Search for a way to fold the skeleton into the target, and keep it for the stages below"""

    bl_idname = "transformables.embed"
    bl_label = "Find Folded Pose"
    bl_options = {"UNDO"}
    until = "embedding"


CLASSES = (TRANSFORMABLES_OT_embed,)
