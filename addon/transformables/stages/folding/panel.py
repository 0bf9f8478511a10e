# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy

from ...core import blocks as rows
from ...ui import block_overlay, blocks, session
from ...ui.panel import StagePanel, labels

ICONS = {rows.MEETS: "ERROR", rows.UNPROVED: "QUESTION", rows.TO_CARVE: "SCULPTMODE_HLT", rows.CARVED: "CHECKMARK"}
STANDING = {rows.MEETS: "Carving alone could not part them. What may help:", rows.UNPROVED: "Carving alone could not part them. What may help:",
            rows.TO_CARVE: "What can be done:", rows.CARVED: "The design is sound. To lose less there:"}


class TRANSFORMABLES_PT_folding(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_folding"
    bl_label = "Folding"
    bl_order = 5
    stage = "folding"
    operator = "transformables.plan_fold"

    def draw_settings(self, context, layout):
        stage = context.scene.transformables.folding_stage
        layout.prop(stage, "seconds")
        layout.prop(stage, "together")
        layout.prop(stage, "frames")
        layout.prop(stage, "loop")
        rig = blocks.rig_of(context.scene)
        if rig is not None:
            layout.operator("transformables.retime", icon="TIME")
            self._draw_slider(layout, rig)

    def _draw_slider(self, layout, rig):
        on = bool(rig.get("use_fold_slider"))
        layout.operator("transformables.fold_slider", text="Fold by Timeline" if on else "Fold by Slider", icon="PLAY" if on else "DRIVER")
        if on:
            layout.prop(rig, '["fold"]', text="Fold", slider=True)

    def draw_stored(self, context, layout):
        path = json.loads(context.scene.transformables.folding_stage.stored)
        moves = path.get("moves", [])
        labels(layout, context, f"{len(moves)} moves from folded to character")


class TRANSFORMABLES_UL_blocks(bpy.types.UIList):
    """Pairs of parts in each other's way, one a row."""

    bl_idname = "TRANSFORMABLES_UL_blocks"

    def draw_item(self, context, layout, data, item, icon, active_data, active_propname, index):
        facts = item.facts()
        row = layout.split(factor=0.66)
        row.label(text=", ".join(facts["bones"]), icon=ICONS[facts["state"]])
        row.label(text=rows.volume_words(facts["volume_mm3"]) if facts["volume_mm3"] else "")


class TRANSFORMABLES_PT_blocks(bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_blocks"
    bl_label = "In the Way"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Transformables"
    bl_parent_id = "TRANSFORMABLES_PT_folding"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return len(context.scene.transformables.folding_stage.blocks) > 0

    def draw(self, context):
        layout, stage = self.layout, context.scene.transformables.folding_stage
        layout.enabled = session.current() is None
        layout.template_list("TRANSFORMABLES_UL_blocks", "", stage, "blocks", stage, "block", rows=4)
        facts = blocks.chosen(context.scene)
        if facts is None:
            return
        labels(layout, context, rows.words(facts), ICONS[facts["state"]])
        row = layout.row(align=True)
        row.operator("transformables.show_block", icon="HIDE_OFF")
        if block_overlay.shown():
            row.operator("transformables.hide_block", icon="HIDE_ON")
        labels(layout, context, STANDING[facts["state"]])
        self._draw_remedies(context, layout.column(align=True), stage, facts)

    def _draw_remedies(self, context, column, stage, facts):
        if facts["state"] == rows.TO_CARVE:
            column.operator("transformables.finish", text="Carve It Away", icon="SCULPTMODE_HLT")
        for which, bone in zip(("first", "second"), facts["bones"]):
            column.operator("transformables.less_skin", text=f"Less on {bone}", icon="FREEZE").which = which
        column.operator("transformables.keep_apart", icon="VIEWZOOM")
        if blocks.joints(context.scene):
            column.separator()
            row = column.row(align=True)
            row.prop(stage, "lock_joint", text="")
            row.prop(stage, "lock_angle", text="")
            column.operator("transformables.lock_joint", icon="LOCKED")


CLASSES = (TRANSFORMABLES_UL_blocks, TRANSFORMABLES_PT_folding, TRANSFORMABLES_PT_blocks)
