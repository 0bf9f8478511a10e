# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy

from ...ui.panel import StagePanel, labels


class TRANSFORMABLES_PT_folding(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_folding"
    bl_label = "Folding"
    bl_order = 5
    stage = "folding"
    operator = "transformables.plan_fold"

    def draw_stored(self, context, layout):
        path = json.loads(context.scene.transformables.folding_stage.stored)
        moves = path.get("moves", [])
        labels(layout, context, f"{len(moves)} moves from folded to character")


CLASSES = (TRANSFORMABLES_PT_folding,)
