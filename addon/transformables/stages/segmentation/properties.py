# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last division of the target among the bones gave."""

import bpy
from bpy.props import StringProperty


class TransformablesSegmentationSettings(bpy.types.PropertyGroup):
    stored: StringProperty(
        name="Parts", options={"HIDDEN"}, description="Each bone's share of the target, as JSON text")
    stored_for: StringProperty(options={"HIDDEN"})


CLASSES = (TransformablesSegmentationSettings,)
