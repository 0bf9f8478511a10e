# SPDX-License-Identifier: GPL-3.0-or-later
"""How finely the target is sampled, and how large it will be in print."""

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty


class TransformablesTargetSettings(bpy.types.PropertyGroup):
    resolution: IntProperty(
        name="Resolution", default=64, min=16, max=512, soft_max=192,
        description="Detail of the design: cells along the target's longest side. "
                    "Twice the number takes about eight times as long")
    size_mm: FloatProperty(
        name="Size (mm)", default=150.0, min=1.0, max=10000.0, soft_min=40.0, soft_max=400.0, precision=1, step=100,
        description="Length of the target's longest side when it is printed, in millimeters")
    stored: StringProperty(name="Findings", description="What was found in the mesh", options={"HIDDEN"})
    stored_for: StringProperty(options={"HIDDEN"})


CLASSES = (TransformablesTargetSettings,)
