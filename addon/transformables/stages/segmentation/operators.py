# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
from bpy.props import EnumProperty

from ...ui import settings
from ...ui.job_operator import JobOperator
from . import seam_operator
from .properties import TO_ADD


class TRANSFORMABLES_OT_segment(JobOperator, bpy.types.Operator):
    """Divide the target among the bones, starting from the folded pose that was found"""

    bl_idname = "transformables.segment"
    bl_label = "Divide Target into Parts"
    bl_options = {"UNDO"}
    until = "segmentation"
    uses_stored = ("embedding",)


class TRANSFORMABLES_OT_add_edit(bpy.types.Operator):
    """Add a wish for how the target is divided. The active bone and the target's active vertex group are filled in"""

    bl_idname = "transformables.add_edit"
    bl_label = "Add Wish"
    bl_options = {"UNDO"}

    kind: EnumProperty(name="Kind", items=TO_ADD, description="What is wished for")

    def execute(self, context):
        stage = context.scene.transformables.segmentation_stage
        character, target = settings.picked(context.scene, "character"), settings.picked(context.scene, "target")
        edit = stage.edits.add()
        edit.kind = self.kind
        if self.kind != "keep_whole" and character is not None and character.data.bones.active is not None:
            edit.bone = character.data.bones.active.name
        if self.kind in ("keep_whole", "assign") and target is not None and target.vertex_groups.active is not None:
            edit.group = target.vertex_groups.active.name
        stage.active_edit = len(stage.edits) - 1
        return {"FINISHED"}


class TRANSFORMABLES_OT_remove_edit(bpy.types.Operator):
    """Take the chosen wish off the list"""

    bl_idname = "transformables.remove_edit"
    bl_label = "Remove Wish"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        stage = context.scene.transformables.segmentation_stage
        if not 0 <= stage.active_edit < len(stage.edits):
            cls.poll_message_set("No wish is chosen")
            return False
        return True

    def execute(self, context):
        stage = context.scene.transformables.segmentation_stage
        stage.edits.remove(stage.active_edit)
        stage.active_edit = max(0, min(stage.active_edit, len(stage.edits) - 1))
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_segment, TRANSFORMABLES_OT_add_edit, TRANSFORMABLES_OT_remove_edit, *seam_operator.CLASSES)
