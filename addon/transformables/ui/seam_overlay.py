# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the seams between parts on the target, and one that is being dragged, in the 3D view."""

import json

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from . import settings

COLOR, WIDTH = (0.05, 0.55, 1.0, 0.9), 2.0
DRAGGED_COLOR, DRAGGED_WIDTH = (1.0, 0.85, 0.1, 1.0), 4.0
CHANGING_COLOR = (1.0, 0.85, 0.1, 0.35)

_handle = []
_kept = {"text": "", "batch": None}   # the last seams drawn, and what they were made of
_dragged = []                         # a curve in the target's own space
_changing = []                        # corners of triangles, three each, there


def show_dragged(points, changing=()):
    """Draws this curve and these triangles (corners, three each), in the target's own space, until it is called with nothing."""
    _dragged[:] = points
    _changing[:] = changing


def lines(text):
    """Points, two a line, of seams as the scene keeps them."""
    pairs = []
    for seam in json.loads(text) if text else ():
        points = seam["points"]
        pairs += [p for pair in zip(points, points[1:]) for p in pair]
        if seam["closed"]:
            pairs += [points[-1], points[0]]
    return pairs


def in_object_mode(scene, target):
    """Whether the target's shape is to be seen: itself, or parts at the end of their fold. Elsewhere seams would hang in the air."""
    return target.visible_get() or scene.frame_current >= scene.frame_end


def _draw():
    scene = bpy.context.scene
    stage = scene.transformables.segmentation_stage
    target = settings.picked(scene, "target")
    if target is None or not (stage.show_seams and stage.seams and in_object_mode(scene, target) or _dragged):
        return
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    if _kept["text"] != stage.seams:
        pairs = lines(stage.seams)
        _kept.update(text=stage.seams, batch=batch_for_shader(shader, "LINES", {"pos": pairs}) if pairs else None)
    gpu.state.depth_test_set("NONE")  # parts may cover the target's surface
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(target.matrix_world)
        if stage.show_seams and _kept["batch"] is not None:
            _draw_batch(shader, _kept["batch"], COLOR, WIDTH)
        if _changing:
            _draw_triangles(_changing)
        if len(_dragged) > 1:
            _draw_batch(shader, batch_for_shader(shader, "LINE_STRIP", {"pos": _dragged}), DRAGGED_COLOR, DRAGGED_WIDTH)
    gpu.state.blend_set("NONE")


def _draw_triangles(corners):
    shader = gpu.shader.from_builtin("UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("color", CHANGING_COLOR)
    batch_for_shader(shader, "TRIS", {"pos": corners}).draw(shader)


def _draw_batch(shader, batch, color, width):
    region = bpy.context.region
    shader.bind()
    shader.uniform_float("viewportSize", (region.width, region.height))
    shader.uniform_float("lineWidth", width * bpy.context.preferences.system.ui_scale)
    shader.uniform_float("color", color)
    batch.draw(shader)


def register():
    if bpy.app.background:
        return  # nothing is drawn without a window, and there may be no GPU
    _handle.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister():
    show_dragged(())
    _kept.update(text="", batch=None)
    while _handle:
        bpy.types.SpaceView3D.draw_handler_remove(_handle.pop(), "WINDOW")
