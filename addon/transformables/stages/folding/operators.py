# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy
from bpy.props import EnumProperty

from ...core.options import UserError
from ...ui import blocks, session
from ...ui.job_operator import JobOperator, options_of


class TRANSFORMABLES_OT_plan_fold(JobOperator, bpy.types.Operator):
    """Find the order in which the joints turn, starting from the folded pose that was found"""

    bl_idname = "transformables.plan_fold"
    bl_label = "Plan the Fold"
    bl_options = {"UNDO"}
    until = "folding"
    uses_stored = ("embedding",)


class _OnRig:
    """What works on the design in the scene."""

    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if session.current() is not None:
            cls.poll_message_set("A design is running: wait for it, or cancel it")
            return False
        if blocks.rig_of(context.scene) is None:
            cls.poll_message_set("There is no design in the scene yet")
            return False
        return True


class TRANSFORMABLES_OT_retime(_OnRig, bpy.types.Operator):
    """Give the fold in the timeline this length, and let it fold back again or not. The design stays as it is"""

    bl_idname = "transformables.retime"
    bl_label = "Apply to Timeline"

    def execute(self, context):
        from ...bridge import design

        try:
            options = options_of(context.scene)
            plan = design.retimed(context.scene, blocks.rig_of(context.scene), options)
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        blocks.move_frames(context.scene, plan)
        self.report({"INFO"}, f"The fold takes {plan.last_frame} frames")
        return {"FINISHED"}


class TRANSFORMABLES_OT_fold_slider(_OnRig, bpy.types.Operator):
    """Fold by a slider instead of the timeline, or by the timeline again. While the slider is on, your own keys on the bones go on top"""

    bl_idname = "transformables.fold_slider"
    bl_label = "Fold by Slider"

    def execute(self, context):
        from ...bridge import animation

        rig = blocks.rig_of(context.scene)
        animation.use_slider(rig, not rig.get("use_fold_slider"))
        session.redraw()
        return {"FINISHED"}


class TRANSFORMABLES_OT_show_block(bpy.types.Operator):
    """Go to the moment at which the chosen pair is most in each other's way, select its two parts, and draw both and the place"""

    bl_idname = "transformables.show_block"
    bl_label = "Show"

    @classmethod
    def poll(cls, context):
        if blocks.chosen(context.scene) is None:
            cls.poll_message_set("Choose a pair of the list first")
            return False
        return True

    def execute(self, context):
        if not blocks.show(context, context.scene):
            self.report({"ERROR"}, "The design that this list is about is not in the scene any more: make it again")
            return {"CANCELLED"}
        return {"FINISHED"}


class TRANSFORMABLES_OT_hide_block(bpy.types.Operator):
    """Stop drawing the two parts and the place"""

    bl_idname = "transformables.hide_block"
    bl_label = "Hide"

    def execute(self, context):
        blocks.hide()
        session.redraw()
        return {"FINISHED"}


class _Remedy(JobOperator):
    """Changes a setting for the sake of the chosen pair and designs again. When there is no new design, the setting goes back, too.

    A subclass has `change(scene, row)`, and `take_back(scene)`, which undoes that as far as the artist has not done so meanwhile.
    """

    @classmethod
    def poll(cls, context):
        if blocks.chosen(context.scene) is None:
            cls.poll_message_set("Choose a pair of the list first")
            return False
        return super().poll(context)

    def _begin(self, context):
        self.change(context.scene, blocks.chosen(context.scene))
        begun = super()._begin(context)
        if not begun:
            self.take_back(context.scene)
        return begun

    def _step(self, context):
        outcome = super()._step(context)
        if outcome == {"CANCELLED"} and self._running.scene in bpy.data.scenes:
            self.take_back(bpy.data.scenes[self._running.scene])
        return outcome


class TRANSFORMABLES_OT_less_skin(_Remedy, bpy.types.Operator):
    """Hold back the growth of one of the two parts: what it held goes to its neighbors, and the design is made again. This adds a wish to the list in Segmentation"""

    bl_idname = "transformables.less_skin"
    bl_label = "Less on This Part"
    bl_options = {"UNDO"}
    uses_stored = ("embedding",)
    which: EnumProperty(name="Part", items=(("first", "First", "The pair's first part"), ("second", "Second", "The pair's second part")),
                        description="The part that gives way")

    def change(self, scene, row):
        stage = scene.transformables.segmentation_stage
        self._bone = row["bones"][0 if self.which == "first" else 1]
        edit = stage.edits.add()
        edit.kind, edit.bone = "inhibit", self._bone
        stage.active_edit = len(stage.edits) - 1

    def take_back(self, scene):
        edits = scene.transformables.segmentation_stage.edits
        if len(edits) and (edits[-1].kind, edits[-1].bone) == ("inhibit", self._bone):
            edits.remove(len(edits) - 1)


class TRANSFORMABLES_OT_lock_joint(_Remedy, bpy.types.Operator):
    """Hold this joint at this angle in the folded pose, let all others find their places from where they are, and make the design again. The joint is then locked in the list in Steering"""

    bl_idname = "transformables.lock_joint"
    bl_label = "Lock and Try Again"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if not blocks.joints(context.scene):
            cls.poll_message_set("This pair has no joint that could be locked")
            return False
        return super().poll(context)

    def change(self, scene, row):
        stage, group = scene.transformables.folding_stage, scene.transformables.embedding_stage
        angle = int(stage.lock_joint)
        self._bone = next(bone for bone, _, index in blocks.joints(scene) if index == angle)
        self._start = json.loads(group.stored)
        self._start["angles"][angle] = stage.lock_angle
        if self._bone not in group.bones:
            group.bones.add().name = self._bone
        self._locked_before = group.bones[self._bone].lock
        group.bones[self._bone].lock = True

    def take_back(self, scene):
        bones = scene.transformables.embedding_stage.bones
        if self._bone in bones:
            bones[self._bone].lock = self._locked_before

    def more_fields(self, context, character):
        return {"start": self._start}


class TRANSFORMABLES_OT_keep_apart(_Remedy, bpy.types.Operator):
    """Search for another folded pose, in which these two parts get in each other's way less, and make the design again. The present pose stays when no better one is found. The pair is then listed in Steering"""

    bl_idname = "transformables.keep_apart"
    bl_label = "Look for Another Pose"
    bl_options = {"UNDO"}

    def change(self, scene, row):
        group = scene.transformables.embedding_stage
        self._pair, self._seed = set(row["bones"]), group.seed
        self._known = any({pair.bone, pair.other} == self._pair for pair in group.apart)
        if not self._known:
            pair = group.apart.add()
            pair.bone, pair.other = row["bones"]
        group.seed += 1  # else the search would find the poses that it knows

    def take_back(self, scene):
        group = scene.transformables.embedding_stage
        if group.seed == self._seed + 1:
            group.seed = self._seed
        if not self._known and len(group.apart) and {group.apart[-1].bone, group.apart[-1].other} == self._pair:
            group.apart.remove(len(group.apart) - 1)

    def more_fields(self, context, character):
        stored = context.scene.transformables.embedding_stage.stored
        return {"rival": json.loads(stored)} if stored else {}


class TRANSFORMABLES_OT_forget_apart(bpy.types.Operator):
    """Take this pair off the list"""

    bl_idname = "transformables.forget_apart"
    bl_label = "Remove Pair"
    bl_options = {"UNDO"}
    index: bpy.props.IntProperty(name="Pair", min=0, description="Which of the list's pairs")

    def execute(self, context):
        apart = context.scene.transformables.embedding_stage.apart
        if self.index >= len(apart):
            return {"CANCELLED"}
        apart.remove(self.index)
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_plan_fold, TRANSFORMABLES_OT_retime, TRANSFORMABLES_OT_fold_slider, TRANSFORMABLES_OT_show_block, TRANSFORMABLES_OT_hide_block, TRANSFORMABLES_OT_less_skin,
           TRANSFORMABLES_OT_lock_joint, TRANSFORMABLES_OT_keep_apart, TRANSFORMABLES_OT_forget_apart)
