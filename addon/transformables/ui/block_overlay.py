# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws two parts in each other's way through all that hides them, and a ball where they meet."""

import math

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Vector

from . import viewport

COLORS = ((1.0, 0.45, 0.1, 0.3), (0.2, 0.55, 1.0, 0.3))  # of the first part, of the second
BALL_COLOR, BALL_WIDTH = (1.0, 0.1, 0.1, 1.0), 2.5
CORNERS = 32  # of a circle

_shown = {}  # names and numbers only: "parts", "rig", "bone", "place", "radius"
_batches = {}  # made when first drawn: part's name -> batch


def show(parts, rig, row):
    """Draws the objects of these names from now on, and a ball at the row's place on the rig's bone of that name."""
    clear()
    _shown.update(parts=list(parts), rig=rig, bone=row["bones"][0], place=row["place"], radius=row["radius"])


def clear():
    _shown.clear()
    _batches.clear()


def shown():
    return bool(_shown)


def place():
    """Where the ball is, in the world, as the rig stands now; None when that is not known, or the rig is gone."""
    rig = bpy.data.objects.get(_shown.get("rig", ""))
    if rig is None or _shown["place"] is None or _shown["bone"] not in rig.pose.bones:
        return None
    return rig.matrix_world @ rig.pose.bones[_shown["bone"]].matrix @ Vector(_shown["place"])


def circles(centre, radius):
    """Ends of lines, two a line: a circle about each axis."""
    points = []
    for axis in range(3):
        for k in range(CORNERS):
            for step in (k, k + 1):
                turn = 2 * math.pi * step / CORNERS
                offset = Vector((math.cos(turn), math.sin(turn), 0))
                points.append(centre + radius * Vector((offset[(axis + 1) % 3], offset[(axis + 2) % 3], offset[axis])))
    return points


def _draw():
    if not _shown:
        return
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("ALPHA")
    gpu.state.face_culling_set("BACK")  # else far sides would show twice as strong
    for name, color in zip(_shown["parts"], COLORS):
        part = bpy.data.objects.get(name)
        if part is not None and part.visible_get():
            _draw_part(part, color)
    gpu.state.face_culling_set("NONE")
    centre = place()
    if centre is not None:
        _draw_ball(centre)
    gpu.state.blend_set("NONE")


def _draw_part(part, color):
    shader = gpu.shader.from_builtin("UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_UNIFORM_COLOR")
    if part.name not in _batches:
        part.data.calc_loop_triangles()
        corners = np.empty(3 * len(part.data.vertices), np.float32)
        part.data.vertices.foreach_get("co", corners)
        triangles = np.empty(3 * len(part.data.loop_triangles), np.int32)
        part.data.loop_triangles.foreach_get("vertices", triangles)
        _batches[part.name] = batch_for_shader(shader, "TRIS", {"pos": corners.reshape(-1, 3)}, indices=triangles.reshape(-1, 3))
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(part.matrix_world)
        shader.bind()
        shader.uniform_float("color", color)
        _batches[part.name].draw(shader)


def _draw_ball(centre):
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    region = bpy.context.region
    shader.bind()
    shader.uniform_float("viewportSize", (region.width, region.height))
    shader.uniform_float("lineWidth", BALL_WIDTH * bpy.context.preferences.system.ui_scale)
    shader.uniform_float("color", BALL_COLOR)
    batch_for_shader(shader, "LINES", {"pos": circles(centre, _shown["radius"])}).draw(shader)


def register():
    viewport.add(_draw)


def unregister():
    clear()
    viewport.remove(_draw)
