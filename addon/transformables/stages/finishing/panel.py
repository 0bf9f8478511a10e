# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui import blocks
from ...ui.panel import StagePanel


class TRANSFORMABLES_PT_finishing(StagePanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_finishing"
    bl_label = "Finishing"
    bl_order = 6
    stage = "finishing"
    operator = "transformables.finish"

    def kept(self, context):
        return ""  # its result is the design itself, in its own collection

    def draw_settings(self, context, layout):
        s = context.scene.transformables.finishing_stage
        layout.prop(s, "clearance_mm")
        layout.prop(s, "style")
        row = layout.column()
        row.active = s.style == "shell"
        row.prop(s, "wall_mm")
        layout.prop(s, "hinges")
        if blocks.rig_of(context.scene) is not None:
            layout.operator("transformables.export_parts", icon="EXPORT")


CLASSES = (TRANSFORMABLES_PT_finishing,)
