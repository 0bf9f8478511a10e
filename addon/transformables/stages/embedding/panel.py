# SPDX-License-Identifier: GPL-3.0-or-later
import json

import bpy

from ...ui import overlays, session, thumbnail
from ...ui.panel import StagePanel, labels

TERMS = (("total", "Score (low is good)"), ("compact", "Compactness"), ("skin", "Skin"), ("skeleton", "Skeleton"), ("protrude", "Sticking Out"),
         ("unfold", "Unfolding"))
BARS = ("compact", "skin", "skeleton", "protrude", "unfold")
WEIGHTS = ("compact", "skin", "skeleton", "protrude", "unfold", "morphology")


def draw_faults(layout, context, embedding):
    """Whether the skeleton is inside and free of collisions, and which bones are not."""
    if "outside" not in embedding:
        return  # a pose of an older version
    outside, colliding = embedding["outside"], embedding["colliding"]
    if not outside and not colliding:
        labels(layout, context, "All bones are inside, none collide", "CHECKMARK")
    if outside:
        labels(layout, context, f"Sticking out of the target: {', '.join(outside)}", "ERROR")
    if colliding:
        labels(layout, context, f"Running into each other: {', '.join(f'{a} and {b}' for a, b in colliding)}", "ERROR")


class TRANSFORMABLES_UL_bones(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=item.name)
        row.prop(item, "lock", text="", icon="LOCKED" if item.lock else "UNLOCKED", emboss=False)
        row.prop(item, "pin", text="", icon="PINNED" if item.pin else "UNPINNED", emboss=False)


class TRANSFORMABLES_UL_solutions(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=item.name, icon_value=thumbnail.icon(item.thumbnail))
        row.label(text=f"{item.score:.4g}")
        row.prop(item, "kept", text="", icon="FAKE_USER_ON" if item.kept else "FAKE_USER_OFF", emboss=False)


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
        embedding = json.loads(context.scene.transformables.embedding_stage.stored)
        terms = embedding.get("terms", {})
        column = layout.column(align=True)
        column.scale_y = 0.8
        for key, words in TERMS:
            if key in terms:
                row = column.split(factor=0.65)
                row.label(text=words)
                row.label(text=f"{terms[key]:.4g}")
        draw_faults(layout, context, embedding)
        if overlays.shown():
            layout.operator("transformables.hide_pose", icon="HIDE_ON")


class _SubPanel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Transformables"
    bl_parent_id = "TRANSFORMABLES_PT_embedding"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.enabled = session.current() is None
        self.draw_group(context, layout, context.scene.transformables.embedding_stage)


class TRANSFORMABLES_PT_steering(_SubPanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_steering"
    bl_label = "Steering"
    bl_order = 0

    def draw_group(self, context, layout, group):
        row = layout.row(align=True)
        row.operator("transformables.continue_pose", icon="PLAY").source = "stored"
        row.operator("transformables.pose_guide", icon="POSE_HLT")
        layout.operator("transformables.continue_pose", text="Continue from Pose Rig", icon="ARMATURE_DATA").source = "guide"
        column = layout.column(align=True)
        for term in WEIGHTS:
            column.prop(group.weights, term)
        layout.operator("transformables.list_bones", icon="BONE_DATA")
        if group.bones:
            layout.template_list("TRANSFORMABLES_UL_bones", "", group, "bones", group, "bone", rows=4)
        self._draw_apart(layout, group)
        if 0 <= group.bone < len(group.bones):
            bone = group.bones[group.bone]
            column = layout.column()
            column.prop(bone, "proportion")
            if bone.proportion == "own":
                column.prop(bone, "least")
                column.prop(bone, "largest")


    def _draw_apart(self, layout, group):
        if group.apart:
            layout.label(text="Keep Apart")
        for index, pair in enumerate(group.apart):
            row = layout.row(align=True)
            row.label(text=f"{pair.bone}, {pair.other}")
            row.operator("transformables.forget_apart", text="", icon="X", emboss=False).index = index


class TRANSFORMABLES_PT_explore(_SubPanel, bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_explore"
    bl_label = "Explore"
    bl_order = 1

    def draw_group(self, context, layout, group):
        layout.prop(group, "explore_count")
        layout.prop(group, "explore_difference")
        layout.operator("transformables.explore", icon="VIEWZOOM")
        if group.solutions:
            layout.template_list("TRANSFORMABLES_UL_solutions", "", group, "solutions", group, "solution", rows=4)
        if 0 <= group.solution < len(group.solutions):
            self._draw_chosen(context, layout, group.solutions[group.solution])

    def _draw_chosen(self, context, layout, solution):
        layout.template_icon(icon_value=thumbnail.icon(solution.thumbnail), scale=5)
        column = layout.column(align=True)
        for term in BARS:
            column.prop(solution, term, slider=True)
        draw_faults(layout, context, json.loads(solution.embedding))
        row = layout.row(align=True)
        row.operator("transformables.use_solution", icon="CHECKMARK")
        row.operator("transformables.delete_solution", icon="TRASH")


CLASSES = (TRANSFORMABLES_UL_bones, TRANSFORMABLES_UL_solutions, TRANSFORMABLES_PT_embedding, TRANSFORMABLES_PT_steering,
           TRANSFORMABLES_PT_explore)
