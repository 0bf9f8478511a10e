# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy

from ...ui import overlays
from ...ui.panel import StagePanel

TERMS = (("total", "Score (low is good)"), ("compact", "Compactness"), ("skin", "Skin"), ("skeleton", "Skeleton"), ("protrude", "Sticking Out"))


class TRANSFORMABLES_PT_embedding(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_embedding"
    bl_label = "Embedding"
    bl_order = 3
    stage = "embedding"
    operator = "transformables.embed"

    def draw_settings(self, context, layout):
        s = context.scene.transformables.embedding_stage
        layout.prop(s, "seed")
        layout.prop(s, "symmetry")
        layout.prop(s, "proportions")

    def draw_stored(self, context, layout):
        terms = json.loads(context.scene.transformables.embedding_stage.stored).get("terms", {})
        column = layout.column(align=True)
        column.scale_y = 0.8
        for key, words in TERMS:
            if key in terms:
                row = column.split(factor=0.65)
                row.label(text=words)
                row.label(text=f"{terms[key]:.4g}")
        if overlays.shown():
            layout.operator("transformables.hide_pose", icon="HIDE_ON")


CLASSES = (TRANSFORMABLES_PT_embedding,)
