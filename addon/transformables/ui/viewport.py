# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawing functions in the 3D view."""

import bpy

_handles = {}  # drawing function -> Blender's handle


def add(draw):
    """Has a function called whenever the 3D view is drawn, in the world's space. Without a window nothing is drawn, and there may be no GPU."""
    if not bpy.app.background:
        _handles[draw] = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW")


def remove(draw):
    """Ends that, if it was."""
    if draw in _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(draw), "WINDOW")
