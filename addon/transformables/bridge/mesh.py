# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: a target's triangles out of Blender, parts into it."""
import bpy
import numpy as np

from ..core.options import UserError


def read_triangles(context, obj):
    """World-space vertices (float64, n x 3) and triangles (int32, m x 3) of an object as it shows, with its modifiers.

    What a mesh holds is passed on as it is, faults included: judging it is the native module's work.
    """
    hidden = obj.hide_viewport
    if hidden:  # a hidden object isn't evaluated; an earlier design has hidden its target
        obj.hide_viewport = False
        context.view_layer.update()
    try:
        return _read_visible(context, obj)
    finally:
        if hidden:
            obj.hide_viewport = True


def _read_visible(context, obj):
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    if not evaluated.is_evaluated and obj.modifiers:
        raise UserError(f"the target '{obj.name}' is in a hidden or excluded collection, so its modifiers can't be applied: show it")
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        vertices = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", vertices)
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
    finally:
        evaluated.to_mesh_clear()
    world = np.array(obj.matrix_world, np.float64)
    # Vertices that are no numbers are passed on; sums with them are no numbers either, and that's no news.
    with np.errstate(invalid="ignore", over="ignore"):
        vertices = vertices.reshape(-1, 3).astype(np.float64) @ world[:3, :3].T + world[:3, 3]
    triangles = triangles.reshape(-1, 3)
    if np.linalg.det(world[:3, :3]) < 0:  # mirrored: what ran counter-clockwise runs clockwise
        triangles = triangles[:, ::-1]
    return np.ascontiguousarray(vertices), np.ascontiguousarray(triangles)


def bounds(vertices, triangles):
    """Lowest and highest corner of what triangles use and is finite; None when nothing is."""
    used = vertices[np.unique(triangles)] if len(triangles) else vertices[:0]
    used = used[np.isfinite(used).all(axis=1)]
    return (used.min(axis=0), used.max(axis=0)) if len(used) else None


def new_mesh(name, vertices, triangles):
    """A triangle mesh from arrays (n x 3 floats, m x 3 ints); nothing is repaired or left out."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(triangles, np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
    if bpy.app.version < (4, 0, 0):  # later it follows from loop_start
        mesh.polygons.foreach_set("loop_total", np.full(len(triangles), 3, np.int32))
    mesh.update(calc_edges=True)
    return mesh
