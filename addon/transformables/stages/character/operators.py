# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...bridge.armature import read_character
from ...core.options import UserError
from ...ui import fingerprint, session, settings
from ...ui.job_operator import options_of


def findings(obj, options):
    """What a design would take of an armature, in lines for the artist. @raises UserError"""
    character = read_character(obj, options.bone_limit())
    hinges = sum(len(h) for h in character.hinges)
    fixed = sum(1 for h, parent in zip(character.hinges, character.parents) if not h and parent >= 0)
    lines = [f"{len(character.names)} of {len(obj.data.bones)} bones are used", f"{hinges} hinges"]
    if fixed:
        lines.append(f"{fixed} bones are fixed to their parents")
    return lines + list(character.warnings)


class TRANSFORMABLES_OT_check_character(bpy.types.Operator):
    """Read the armature as a design would: which bones are kept, and how they can turn. The armature is not changed"""

    bl_idname = "transformables.check_character"
    bl_label = "Check Character"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if settings.picked(context.scene, "character") is None:
            cls.poll_message_set("Pick the character: an armature object of this scene")
            return False
        if session.current() is not None:
            cls.poll_message_set("A design is running: wait for it, or press Esc to cancel it")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        try:
            lines = findings(settings.picked(scene, "character"), options_of(scene))
        except UserError as error:
            session.last.error = str(error)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        group = scene.transformables.character_stage
        group.stored = "\n".join(lines)
        group.stored_for = fingerprint.take(scene, "character")
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_check_character,)
