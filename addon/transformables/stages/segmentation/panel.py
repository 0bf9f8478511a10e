# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy

from ...ui.panel import StagePanel, labels

SHOWN = 8  # bones listed; the panel is no spreadsheet


class TRANSFORMABLES_PT_segmentation(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_segmentation"
    bl_label = "Segmentation"
    bl_order = 4
    stage = "segmentation"
    operator = "transformables.segment"

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


CLASSES = (TRANSFORMABLES_PT_segmentation,)
