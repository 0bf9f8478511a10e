# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...bridge.armature import read_character
from ...ui.check_operator import CheckOperator
from ...ui.job_operator import options_of


class TRANSFORMABLES_OT_check_character(CheckOperator, bpy.types.Operator):
    """Read the armature as a design would: which bones are kept, and how they can turn. The armature is not changed"""

    bl_idname = "transformables.check_character"
    bl_label = "Check Character"
    stage = "character"
    to_pick = "Pick the character: an armature object of this scene"

    def findings(self, context, obj):
        character = read_character(obj, options_of(context.scene).bone_limit())
        hinges = sum(len(h) for h in character.hinges)
        fixed = sum(1 for h, parent in zip(character.hinges, character.parents) if not h and parent >= 0)
        lines = [f"{len(character.names)} of {len(obj.data.bones)} bones are used", f"{hinges} hinges"]
        if fixed:
            lines.append(f"{fixed} bones are fixed to their parents")
        return lines + list(character.warnings)


CLASSES = (TRANSFORMABLES_OT_check_character,)
