# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy
from bpy.props import EnumProperty

from ...core.options import UserError
from ...ui import overlays, results, session, settings
from ...ui.job_operator import JobOperator, options_of


class TRANSFORMABLES_OT_embed(JobOperator, bpy.types.Operator):
    """Search for a way to fold the skeleton into the target, and keep it for the stages below"""

    bl_idname = "transformables.embed"
    bl_label = "Find Folded Pose"
    bl_options = {"UNDO"}
    until = "embedding"


class TRANSFORMABLES_OT_explore(JobOperator, bpy.types.Operator):
    """Search for several really different ways to fold the skeleton into the target, and list them below"""

    bl_idname = "transformables.explore"
    bl_label = "Explore"
    bl_options = {"UNDO"}
    until = "embedding"

    def more_fields(self, context, character):
        group = context.scene.transformables.embedding_stage
        return {"explore": {"count": group.explore_count, "least_difference": group.explore_difference / 100}}


class TRANSFORMABLES_OT_continue_pose(JobOperator, bpy.types.Operator):
    """Search on from this pose in small steps"""

    bl_idname = "transformables.continue_pose"
    bl_label = "Continue"
    bl_options = {"UNDO"}
    until = "embedding"
    source: EnumProperty(
        name="From", items=(("stored", "Folded Pose", "From the folded pose that was found"),
                            ("guide", "Pose Rig", "From the pose that you gave the pose rig")))

    def more_fields(self, context, character):
        from ...bridge import guide

        self.from_guide = self.source == "guide"
        if self.from_guide:
            rig = guide.of(context.scene, character)
            if rig is None:
                raise UserError("There is no pose rig: press Pose by Hand first")
            return {"start": guide.read(context, rig)}
        stored = context.scene.transformables.embedding_stage.stored
        if not stored:
            raise UserError("There is no folded pose to go on from: press Find Folded Pose first")
        return {"start": json.loads(stored)}


class _NotWhileRunning:
    @classmethod
    def poll(cls, context):
        if session.current() is not None:
            cls.poll_message_set("A design is running: wait for it, or cancel it")
            return False
        return True


class TRANSFORMABLES_OT_pose_guide(_NotWhileRunning, bpy.types.Operator):
    """Make a copy of the character in its folded pose, to be posed by hand with Auto IK. Your own armature stays as it is"""

    bl_idname = "transformables.pose_guide"
    bl_label = "Pose by Hand"
    bl_options = {"UNDO"}

    def execute(self, context):
        from ...bridge import guide

        group, character = context.scene.transformables.embedding_stage, settings.picked(context.scene, "character")
        if not group.stored or not group.made_with or character is None:
            self.report({"ERROR"}, "There is no folded pose yet: press Find Folded Pose first")
            return {"CANCELLED"}
        try:
            rig = guide.make(context, character, options_of(context.scene).bone_limit(), json.loads(group.made_with), json.loads(group.stored))
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        bpy.ops.object.mode_set(mode="POSE")
        rig.pose.use_auto_ik = True
        overlays.clear()
        return {"FINISHED"}


class TRANSFORMABLES_OT_list_bones(_NotWhileRunning, bpy.types.Operator):
    """List the character's bones, so that each can be locked, pinned, or given proportions of its own. Settings of bones that are listed already are kept"""

    bl_idname = "transformables.list_bones"
    bl_label = "List Bones"
    bl_options = {"UNDO"}

    def execute(self, context):
        from ...bridge import armature

        group, character = context.scene.transformables.embedding_stage, settings.picked(context.scene, "character")
        if character is None:
            self.report({"ERROR"}, settings.missing(context.scene))
            return {"CANCELLED"}
        try:
            names = armature.read_character(character, options_of(context.scene).bone_limit()).names
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for index in reversed(range(len(group.bones))):
            if group.bones[index].name not in names:
                group.bones.remove(index)
        for name in names:
            if name not in group.bones:
                group.bones.add().name = name
        return {"FINISHED"}


class _OnSolution(_NotWhileRunning):
    """What all operators on the chosen pose of the list share."""

    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        group = context.scene.transformables.embedding_stage
        if not 0 <= group.solution < len(group.solutions):
            cls.poll_message_set("Choose a pose of the list first")
            return False
        return super().poll(context)


class TRANSFORMABLES_OT_use_solution(_OnSolution, bpy.types.Operator):
    """Take this pose for the stages below, and for Continue"""

    bl_idname = "transformables.use_solution"
    bl_label = "Use"

    def execute(self, context):
        group = context.scene.transformables.embedding_stage
        results.use(context.scene, group.solutions[group.solution])
        return {"FINISHED"}


class TRANSFORMABLES_OT_delete_solution(_OnSolution, bpy.types.Operator):
    """Take this pose out of the list"""

    bl_idname = "transformables.delete_solution"
    bl_label = "Delete"

    def execute(self, context):
        group = context.scene.transformables.embedding_stage
        group.solutions.remove(group.solution)
        group.solution = max(0, min(group.solution, len(group.solutions) - 1))
        if not group.solutions:
            overlays.clear()
        return {"FINISHED"}


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


CLASSES = (TRANSFORMABLES_OT_embed, TRANSFORMABLES_OT_explore, TRANSFORMABLES_OT_continue_pose, TRANSFORMABLES_OT_pose_guide,
           TRANSFORMABLES_OT_list_bones, TRANSFORMABLES_OT_use_solution, TRANSFORMABLES_OT_delete_solution, TRANSFORMABLES_OT_hide_pose)
