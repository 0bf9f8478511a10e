# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which the joints unfold."""

import bpy
from bpy.props import StringProperty


class TransformablesFoldingSettings(bpy.types.PropertyGroup):
    stored: StringProperty(
        name="Fold Path", options={"HIDDEN"},
        description="The order in which the joints turn, as JSON text; Finishing starts from it")
    stored_for: StringProperty(options={"HIDDEN"})


CLASSES = (TransformablesFoldingSettings,)
