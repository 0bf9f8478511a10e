# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on shows where Blender's Python has no NumPy: why it can't work and what to do, in the places of its panels."""

import sys

import bpy

from ..bridge import system_python
from .words import labels


class TRANSFORMABLES_PT_without_numpy(bpy.types.Panel):
    bl_idname = "TRANSFORMABLES_PT_without_numpy"
    bl_label = "Transformables"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Transformables"

    def draw(self, context):
        labels(self.layout, context, system_python.advice(), "ERROR")


def _preferences_class(package):
    class TRANSFORMABLES_AP_without_numpy(bpy.types.AddonPreferences):
        bl_idname = package

        def draw(self, context):
            labels(self.layout, context, system_python.advice(), "ERROR")

    return TRANSFORMABLES_AP_without_numpy


_registered = []


def register(package):
    """Registers the two texts, and says the same on the console."""
    for cls in (TRANSFORMABLES_PT_without_numpy, _preferences_class(package)):
        bpy.utils.register_class(cls)
        _registered.append(cls)
    print(f"transformables: {system_python.advice()}", file=sys.stderr, flush=True)


def unregister():
    """Takes the texts away, where they were shown."""
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
