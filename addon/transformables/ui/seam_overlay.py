# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws in the 3D view the seams between parts on the target, and one that is being dragged with the parts that follow it."""

import json

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..bridge import division, rig
from ..core.division import normals
from . import settings, viewport

COLOR, WIDTH = (0.05, 0.55, 1.0, 0.9), 2.0
DRAGGED_COLOR, DRAGGED_WIDTH = (1.0, 0.85, 0.1, 1.0), 4.0
NO_PART = (0.4, 0.4, 0.4)
LIGHT, LEAST_LIGHT = np.array((0.36, -0.48, 0.8)), 0.45
LIFT = 0.004   # of the target's longest side: over the parts that are there

_kept = {"text": "", "batch": None}   # the last seams drawn, and what they were made of
_released = {"when": None, "batch": None}   # the division as the last drag left it
_dragged = {"curve": (), "surface": None, "parts": None, "batch": None}


class Surface:
    """The target's surface to be drawn in its parts' colours: vertices, triangles (of bridge/division.py)."""

    def __init__(self, vertices, triangles):
        self.normals = normals(vertices, triangles)
        lift = LIFT * np.ptp(vertices, axis=0).max()
        self._places, self._triangles = (vertices + lift * self.normals).astype(np.float32), triangles
        self._light = LEAST_LIGHT + (1 - LEAST_LIGHT) * (self.normals @ LIGHT).clip(0)

    def batch(self, parts):
        """With each vertex in the colour of its part."""
        palette = np.array([rig.body_color(body)[:3] for body in range(parts.max() + 1)] + [NO_PART])  # -1 is the last
        colors = np.ones((len(parts), 4), np.float32)
        colors[:, :3] = palette[parts] * self._light[:, None]
        return batch_for_shader(_shader("SMOOTH_COLOR"), "TRIS", {"pos": self._places, "color": colors}, indices=self._triangles)


def show_dragged(curve, surface=None, parts=None):
    """Draws this curve and this Surface divided into these parts, in the target's own space, until it is called with nothing."""
    _dragged.update(curve=curve, surface=surface, parts=parts, batch=None)  # made when it is drawn: only then there is a GPU for certain


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
    shows = target is not None and stage.show_seams and stage.seams and in_object_mode(scene, target)
    if target is None or not (shows or _dragged["curve"]):
        return
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(target.matrix_world)
        if _dragged["surface"] is not None:
            _dragged["batch"] = _dragged["batch"] or _dragged["surface"].batch(_dragged["parts"])
            _draw_surface(_dragged["batch"])
        elif shows and stage.division is not None and division.DRAGGED in stage.division:
            _draw_surface(_released_batch(stage.division))
        gpu.state.depth_test_set("NONE")  # parts may cover the target's surface
        if stage.show_seams and stage.seams:
            _draw_lines(_seams_batch(stage.seams), COLOR, WIDTH)
        if len(_dragged["curve"]) > 1:
            _draw_lines(batch_for_shader(_shader("POLYLINE_UNIFORM_COLOR"), "LINE_STRIP", {"pos": _dragged["curve"]}), DRAGGED_COLOR, DRAGGED_WIDTH)
    gpu.state.blend_set("NONE")


def _seams_batch(text):
    if _kept["text"] != text:
        pairs = lines(text)
        _kept.update(text=text, batch=batch_for_shader(_shader("POLYLINE_UNIFORM_COLOR"), "LINES", {"pos": pairs}) if pairs else None)
    return _kept["batch"]


def _released_batch(data):
    """Parts that a drag has moved, drawn until the target is divided again."""
    if _released["when"] != data[division.DRAGGED]:
        vertices, triangles, parts = division.read(data)
        _released.update(when=data[division.DRAGGED], batch=Surface(vertices, triangles).batch(parts))
    return _released["batch"]


def _shader(name):
    old = bpy.app.version < (4, 0, 0) and not name.startswith("POLYLINE")
    return gpu.shader.from_builtin(f"3D_{name}" if old else name)


def _draw_surface(batch):
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    batch.draw(_shader("SMOOTH_COLOR"))
    gpu.state.depth_mask_set(False)


def _draw_lines(batch, color, width):
    if batch is None:
        return
    region, shader = bpy.context.region, _shader("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", (region.width, region.height))
    shader.uniform_float("lineWidth", width * bpy.context.preferences.system.ui_scale)
    shader.uniform_float("color", color)
    batch.draw(shader)


def register():
    viewport.add(_draw)


def unregister():
    show_dragged(())
    _kept.update(text="", batch=None)
    _released.update(when=None, batch=None)
    viewport.remove(_draw)
