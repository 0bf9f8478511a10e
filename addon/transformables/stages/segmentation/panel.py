# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy

from ...ui import settings
from ...ui.panel import StagePanel, labels
from .properties import KINDS, TO_ADD

SHOWN = 8  # bones listed; the panel is no spreadsheet


class TRANSFORMABLES_UL_edits(bpy.types.UIList):
    """The artist's wishes, one a row."""

    bl_idname = "TRANSFORMABLES_UL_edits"

    def draw_item(self, context, layout, data, item, icon, active_data, active_propname, index):
        row = layout.row(align=True)
        row.use_property_split = False  # the panel's would leave half of the row empty
        row.prop(item, "enabled", text="")
        label = row.row()
        label.active = item.enabled
        name = item.label() if item.kind == "move_seam" else item.group or item.bone or item.label()  # the icon tells the kind
        label.label(text=name, icon=next(kind[3] for kind in KINDS if kind[0] == item.kind))


class TRANSFORMABLES_MT_add_edit(bpy.types.Menu):
    bl_idname = "TRANSFORMABLES_MT_add_edit"
    bl_label = "Add Wish"

    def draw(self, context):
        for kind, words, _, icon, _ in TO_ADD:
            self.layout.operator("transformables.add_edit", text=words, icon=icon).kind = kind


class TRANSFORMABLES_PT_segmentation(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_segmentation"
    bl_label = "Segmentation"
    bl_order = 4
    stage = "segmentation"
    operator = "transformables.segment"

    def draw_settings(self, context, layout):
        stage = context.scene.transformables.segmentation_stage
        layout.prop(stage, "transfer")
        layout.label(text="Wishes")
        row = layout.row()
        row.template_list("TRANSFORMABLES_UL_edits", "", stage, "edits", stage, "active_edit", rows=3)
        buttons = row.column(align=True)
        buttons.menu("TRANSFORMABLES_MT_add_edit", text="", icon="ADD")
        buttons.operator("transformables.remove_edit", text="", icon="REMOVE")
        if 0 <= stage.active_edit < len(stage.edits):
            self._draw_edit(context, layout.box(), stage.edits[stage.active_edit])

    def _draw_edit(self, context, box, edit):
        character, target = settings.picked(context.scene, "character"), settings.picked(context.scene, "target")
        box.active = edit.enabled
        box.label(text=edit.label(), icon=next(kind[3] for kind in KINDS if kind[0] == edit.kind))
        if edit.kind == "move_seam":
            box.label(text="Drag the seam again to change it")
            return
        if edit.kind != "keep_whole" and character is not None:
            box.prop_search(edit, "bone", character.data, "bones")
        if edit.kind == "inhibit":
            box.prop(edit, "thickness_mm")
        if edit.kind in ("keep_whole", "assign") and target is not None:
            box.prop_search(edit, "group", target, "vertex_groups")

    def draw_stored(self, context, layout):
        shares = json.loads(context.scene.transformables.segmentation_stage.stored)
        largest = sorted(shares.items(), key=lambda item: -item[1])
        labels(layout, context, f"{len(shares)} parts, by their share of the target:")
        column = layout.column(align=True)
        column.scale_y = 0.8
        for name, share in largest[:SHOWN]:
            row = column.split(factor=0.7)
            row.label(text=name)
            row.label(text=f"{100 * share:.1f} %")
        if len(largest) > SHOWN:
            labels(layout, context, f"and {len(largest) - SHOWN} smaller ones")
        stage = context.scene.transformables.segmentation_stage
        if stage.seams:
            layout.prop(stage, "show_seams")
            layout.operator("transformables.move_seam", icon="MOD_CURVE")


CLASSES = (TRANSFORMABLES_UL_edits, TRANSFORMABLES_MT_add_edit, TRANSFORMABLES_PT_segmentation)
