# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences. Its id is the package's name, which an extension gets from Blender."""

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty

_registered = []


class Defaults:
    """What holds when the add-on has no preferences of its own, as when a script registers it directly."""

    threads = 0
    show_pose = True
    pose_color = (1.0, 0.55, 0.1, 1.0)
    pose_width = 3.0


def _preferences_class(package):
    class TRANSFORMABLES_AP_preferences(bpy.types.AddonPreferences):
        bl_idname = package

        threads: IntProperty(
            name="Processor Cores", min=0, max=256, default=Defaults.threads,
            description="How many processor cores a design may use; 0 uses all. The design is the same either way")
        show_pose: BoolProperty(
            name="Show the Pose While It Is Searched", default=Defaults.show_pose,
            description="Draw the best folded skeleton so far inside the target while a design is running")
        pose_color: FloatVectorProperty(
            name="Color", subtype="COLOR", size=4, min=0, max=1, default=Defaults.pose_color,
            description="Color of the skeleton that is drawn inside the target")
        pose_width: FloatProperty(
            name="Line Width", subtype="PIXEL", min=1, max=10, default=Defaults.pose_width,
            description="Thickness of the skeleton's lines")

        def draw(self, context):
            column = self.layout.column()
            column.use_property_split = True
            column.prop(self, "threads")
            column.prop(self, "show_pose")
            style = column.column()
            style.active = self.show_pose
            style.prop(self, "pose_color")
            style.prop(self, "pose_width")

    return TRANSFORMABLES_AP_preferences


def get():
    """The user's preferences, or the defaults."""
    addon = bpy.context.preferences.addons.get(_registered[0].bl_idname) if _registered else None
    preferences = addon.preferences if addon else None
    return preferences if preferences is not None else Defaults


def register(package):
    cls = _preferences_class(package)
    bpy.utils.register_class(cls)
    _registered.append(cls)


def unregister():
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
