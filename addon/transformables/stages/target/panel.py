# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui import settings
from ...ui.panel import StagePanel, labels


class TRANSFORMABLES_PT_target(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_target"
    bl_label = "Target"
    bl_order = 2
    stage = "target"
    operator = "transformables.check_target"

    def draw_settings(self, context, layout):
        target = settings.picked(context.scene, "target")
        if target is not None:
            labels(layout, context, f"{target.name}: {len(target.data.polygons)} faces", "MESH_DATA")
        s = context.scene.transformables.target_stage
        layout.prop(s, "resolution")
        layout.prop(s, "size_mm")

    def draw_stored(self, context, layout):
        for line in context.scene.transformables.target_stage.stored.splitlines():
            labels(layout, context, line)


CLASSES = (TRANSFORMABLES_PT_target,)
