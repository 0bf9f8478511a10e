# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for the folded pose, and the pose that it found."""

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty


class TransformablesEmbeddingSettings(bpy.types.PropertyGroup):
    seed: IntProperty(
        name="Seed", default=0, min=0,
        description="Try another number to get another way of folding; the same number gives the same design again")
    symmetry: EnumProperty(
        name="Symmetry", default="auto",
        description="Whether the left and right side of the character fold in the same way",
        items=(("auto", "Automatic", "Fold both sides alike when the character and the target are both symmetric"),
               ("on", "On", "Always fold both sides alike; the character and the target must be symmetric"),
               ("off", "Off", "Let each side fold in its own way")))
    proportions: BoolProperty(
        name="Proportions", default=True,
        description="Let single bones become longer or shorter, so that the character fills the target better")
    stored: StringProperty(
        name="Folded Pose", options={"HIDDEN"},
        description="The folded pose that was found, as JSON text; later stages start from it")
    stored_for: StringProperty(options={"HIDDEN"})


CLASSES = (TransformablesEmbeddingSettings,)
