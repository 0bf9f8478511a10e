# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of the settings that are not about one character: resolution, size, clearance, style and how the search goes."""
import bpy
from bl_operators.presets import AddPresetBase

FOLDER = "transformables"
SETTINGS = ("character_stage.simplify", "character_stage.simplify_count", "character_stage.fit", "target_stage.resolution", "target_stage.size_mm",
            "embedding_stage.symmetry", "embedding_stage.proportions", "segmentation_stage.transfer", "finishing_stage.clearance_mm", "finishing_stage.style",
            "finishing_stage.wall_mm", "finishing_stage.hinges", "folding_stage.seconds", "folding_stage.frames", "folding_stage.together", "folding_stage.loop")


class TRANSFORMABLES_MT_presets(bpy.types.Menu):
    bl_idname = "TRANSFORMABLES_MT_presets"
    bl_label = "Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    draw = bpy.types.Menu.draw_preset


class TRANSFORMABLES_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Keep these settings under a name, for other scenes too; or take a kept name away"""

    bl_idname = "transformables.add_preset"
    bl_label = "Add Preset"
    preset_menu = "TRANSFORMABLES_MT_presets"
    preset_subdir = FOLDER
    preset_defines = ["settings = bpy.context.scene.transformables"]
    preset_values = [f"settings.{name}" for name in SETTINGS]


def draw(layout):
    """The menu of presets with its plus and minus."""
    row = layout.row(align=True)
    row.menu(TRANSFORMABLES_MT_presets.bl_idname, text=TRANSFORMABLES_MT_presets.bl_label)
    row.operator(TRANSFORMABLES_OT_add_preset.bl_idname, text="", icon="ADD")
    row.operator(TRANSFORMABLES_OT_add_preset.bl_idname, text="", icon="REMOVE").remove_active = True


CLASSES = (TRANSFORMABLES_MT_presets, TRANSFORMABLES_OT_add_preset)
