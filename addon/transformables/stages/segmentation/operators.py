# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy
from bpy.props import EnumProperty

from ...ui import results, session, settings
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


class TRANSFORMABLES_OT_settle_seams(JobOperator, bpy.types.Operator):
    """Let the parts' shapes follow a seam that was dragged, as long as nothing but the division is there"""

    bl_idname = "transformables.settle_seams"
    bl_label = "Settle Parts"
    bl_options = {"UNDO", "INTERNAL"}
    until = "segmentation"
    uses_stored = ("embedding",)
    gives_way = True

    @classmethod
    def poll(cls, context):
        return session.current() is None and not settings.missing(context.scene) and _is_divided_only(context.scene)

    def _begin(self, context):
        if not results.stored(context.scene, self.uses_stored):
            return False  # the pose is out of date: a new search is the artist's to start
        self._wishes = repr(settings.edits(context.scene))
        return super()._begin(context)

    def _take_events(self, context):
        if repr(settings.edits(context.scene)) != self._wishes:
            self._running.cancel_wanted = True  # the drag was undone, or another wish came: parts would be for wishes that are gone
            return None
        return super()._take_events(context)

    def _take_result(self, context, event):
        super()._take_result(context, event)
        context.scene.frame_set(context.scene.frame_end)  # object mode, as while dragging


def _is_divided_only(scene):
    """Whether the character's result is a division of the target that was not planned or finished yet: no more than that is replaced unasked."""
    character = settings.picked(scene, "character").name
    rigs = [o for o in scene.objects if o.get("transformable_role") == "rig" and o.get("transformable_source") == character]
    return any(json.loads(o.get("transformable_stored", "{}")).get("path", True) is None for o in rigs)


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


CLASSES = (TRANSFORMABLES_OT_segment, TRANSFORMABLES_OT_settle_seams, TRANSFORMABLES_OT_add_edit, TRANSFORMABLES_OT_remove_edit, *seam_operator.CLASSES)
