# SPDX-License-Identifier: GPL-3.0-or-later
"""How the parts are made."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty


class TransformablesFinishingSettings(bpy.types.PropertyGroup):
    clearance_mm: FloatProperty(
        name="Gap (mm)", default=0.3, min=0.0, max=10.0, soft_min=0.1, soft_max=1.0, precision=2, step=5,
        description="Gap between neighboring parts when printed, in millimeters. Common: 0.3 for filament, 0.5 for resin")
    style: EnumProperty(
        name="Style", default="solid", description="Whether parts are filled or hollow",
        items=(("solid", "Solid", "Filled parts"),
               ("shell", "Shell", "Hollow parts with walls of the given thickness")))
    wall_mm: FloatProperty(
        name="Wall (mm)", default=1.2, min=0.4, max=50.0, soft_max=5.0, precision=2, step=10,
        description="Thickness of a hollow part's walls when printed, in millimeters")
    hinges: BoolProperty(
        name="Pins in the Joints", default=True,
        description="Give each joint that turns about one axis a pin, two ears that carry it and a tongue between them, where there is room. "
                    "The parts then hold together when they are printed in place. Otherwise joints are loose balls in sockets")


CLASSES = (TransformablesFinishingSettings,)
