# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar's main panel, and what the stages' sub-panels share."""

import bpy

from . import fingerprint, presets, session, settings
from .words import labels


class StagePanel:
    """A stage's sub-panel. A subclass names its stage, draws its settings, and names its operator."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Transformables"
    bl_parent_id = "TRANSFORMABLES_PT_main"
    bl_options = {"DEFAULT_CLOSED"}
    stage = ""
    operator = ""

    def kept(self, context):
        """The fingerprint of what this stage has stored; empty when it has nothing."""
        return getattr(context.scene.transformables, f"{self.stage}_stage").stored_for

    def draw_header(self, context):
        kept = self.kept(context)
        if kept:
            fits = fingerprint.fits(context.scene, self.stage, kept)
            self.layout.label(text="", icon="CHECKMARK" if fits else "ERROR")

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.enabled = session.current() is None
        self.draw_settings(context, column)
        kept = self.kept(context)
        if kept:
            self.draw_stored(context, layout)
            if not fingerprint.fits(context.scene, self.stage, kept):
                labels(layout, context, "Out of date: the inputs have changed", "ERROR")
        layout.operator(self.operator, icon="PLAY")

    def draw_settings(self, context, layout):
        pass

    def draw_stored(self, context, layout):
        pass


class TRANSFORMABLES_PT_main(bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_main"
    bl_label = "Transformables"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Transformables"

    def draw(self, context):
        layout = self.layout
        self._draw_picks(context, layout.column())
        presets.draw(layout)
        if session.current() is None:
            row = layout.row()
            row.scale_y = 1.8
            row.operator("transformables.design", icon="MOD_BUILD")
        else:
            self._draw_running(context, layout.box())
        self._draw_last(context, layout)

    def _draw_picks(self, context, column):
        column.enabled = session.current() is None
        chosen = context.scene.transformables
        for which, icon in (("character", "ARMATURE_DATA"), ("target", "MESH_DATA")):
            choice, found = getattr(chosen, which), settings.picked(context.scene, which)
            by_itself = f": {found.name} (the only one)" if found is not None and choice is None else ""
            part = column.column(align=True)
            part.label(text=f"{which.capitalize()}{by_itself}")
            part.prop(chosen, which, text="", icon=icon)
            if choice is not None and found is None:
                labels(column, context, "This object is not in the scene any more", "ERROR")

    def _draw_running(self, context, box):
        labels(box, context, session.line(), "TIME")
        row = box.row(align=True)
        bar = row.row(align=True)
        bar.prop(context.window_manager, "transformables_progress", text="", slider=True)
        row.operator("transformables.cancel", icon="X")

    def _draw_last(self, context, layout):
        last = session.last
        if last.error:
            box = layout.box()
            box.alert = True
            labels(box, context, last.error, "ERROR")
        if last.summary:
            labels(layout, context, last.summary, "INFO")
        for text in last.warnings:
            labels(layout, context, text, "ERROR")


CLASSES = (TRANSFORMABLES_PT_main,)
