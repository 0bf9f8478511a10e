# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the folded skeleton inside the target, in the 3D view, while a design is searched."""

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from . import preferences, viewport

_points = []  # world space, two a line
_batch = []   # made when first drawn, thrown away when the points change


def show(points):
    """Draws these lines from now on: world-space points, two a line."""
    _points[:] = [tuple(point) for point in points]
    _batch.clear()


def clear():
    show(())


def shown():
    """How many lines are drawn."""
    return len(_points) // 2


def _draw():
    options = preferences.get()
    if not _points or not options.show_pose:
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    if not _batch:
        _batch.append(batch_for_shader(shader, "LINES", {"pos": _points}))
    region = bpy.context.region
    gpu.state.depth_test_set("NONE")  # the skeleton is inside the target: it must show through
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("viewportSize", (region.width, region.height))
    shader.uniform_float("lineWidth", options.pose_width * bpy.context.preferences.system.ui_scale)
    shader.uniform_float("color", tuple(options.pose_color))
    _batch[0].draw(shader)
    gpu.state.blend_set("NONE")


def register():
    viewport.add(_draw)


def unregister():
    clear()
    viewport.remove(_draw)
