# SPDX-License-Identifier: GPL-3.0-or-later
"""How the armature is read."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty


class TransformablesCharacterSettings(bpy.types.PropertyGroup):
    simplify: EnumProperty(
        name="Simplify", default="auto",
        description="Whether to leave out bones that matter little for folding, such as fingers and face",
        items=(("auto", "Automatic", "Bring a character of more than 25 bones down to 25 at most; leave others as they are"),
               ("off", "Keep All Bones", "Use every bone of the armature"),
               ("count", "Choose", "Bring the character down to the number of bones that you choose")))
    simplify_count: IntProperty(
        name="Bones", default=20, min=2, max=200, soft_max=60,
        description="How many bones to keep at most")
    fit: EnumProperty(
        name="Scale", default="auto",
        description="Whether the character as a whole may be scaled to suit the target",
        items=(("auto", "Fit to Target", "Scale the whole character so that it fills the target well"),
               ("off", "Keep", "Use the character at the size that it has in the scene")))
    stored: StringProperty(name="Findings", description="What was found in the armature", options={"HIDDEN"})
    stored_for: StringProperty(options={"HIDDEN"})


CLASSES = (TransformablesCharacterSettings,)
