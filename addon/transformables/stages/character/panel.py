# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui import settings
from ...ui.panel import StagePanel, labels


class TRANSFORMABLES_PT_character(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_character"
    bl_label = "Character"
    bl_order = 1
    stage = "character"
    operator = "transformables.check_character"

    def draw_settings(self, context, layout):
        character = settings.picked(context.scene, "character")
        if character is not None:
            labels(layout, context, f"{character.name}: {len(character.data.bones)} bones", "ARMATURE_DATA")
        s = context.scene.transformables.character_stage
        layout.prop(s, "simplify")
        if s.simplify == "count":
            layout.prop(s, "simplify_count")
        layout.prop(s, "fit")

    def draw_stored(self, context, layout):
        for line in context.scene.transformables.character_stage.stored.splitlines():
            labels(layout, context, line)


CLASSES = (TRANSFORMABLES_PT_character,)
