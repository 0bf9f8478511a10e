# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: a target's triangles out of Blender, parts into it."""
import bpy
from mathutils.bvhtree import BVHTree
import numpy as np

from ..core.options import UserError

INTERFACE_MATERIAL = "Transformables interface"
IN_GROUP = 0.5  # weight from which a vertex counts as painted


def read_triangles(context, obj):
    """World-space vertices (float64, n x 3) and triangles (int32, m x 3) of an object as it shows, with its modifiers.

    What a mesh holds is passed on as it is, faults included: judging it is the native module's work.
    """
    return _with_visible(context, obj, _triangles_of)[:2]


def read_skin(context, obj):
    """What an object's surface shows, triangle by triangle: a Skin."""
    return _with_visible(context, obj, lambda obj, data: Skin(obj, data, *_triangles_of(obj, data)))


def read_group(context, obj, group):
    """Corners (float64, n x 3 x 3, world space) of the triangles whose every vertex is in a vertex group with at least half its weight,
    on the object as it shows. None when it has no such group."""
    index = obj.vertex_groups.find(group)
    return None if index < 0 else _with_visible(context, obj, lambda obj, data: _corners_in(obj, data, index))


def _corners_in(obj, data, index):
    inside = np.fromiter((any(g.group == index and g.weight >= IN_GROUP for g in v.groups) for v in data.vertices), bool, len(data.vertices))
    vertices, triangles, _ = _triangles_of(obj, data)
    corners = vertices[triangles[inside[triangles].all(axis=1)]]
    return corners[np.isfinite(corners).all(axis=(1, 2))]


def _with_visible(context, obj, read):
    """Gives read(obj, its evaluated mesh)."""
    hidden = obj.hide_viewport
    if hidden:  # a hidden object isn't evaluated; an earlier design has hidden its target
        obj.hide_viewport = False
        context.view_layer.update()
    try:
        evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
        if not evaluated.is_evaluated and obj.modifiers:
            raise UserError(f"the target '{obj.name}' is in a hidden or excluded collection, so its modifiers can't be applied: show it")
        data = evaluated.to_mesh()
        try:
            data.calc_loop_triangles()
            return read(obj, data)
        finally:
            evaluated.to_mesh_clear()
    finally:
        if hidden:
            obj.hide_viewport = True


def _triangles_of(obj, data):
    """World-space vertices, triangles, and for each triangle its loops."""
    vertices = _numbers(data.vertices, "co", 3, np.float32)
    triangles = _numbers(data.loop_triangles, "vertices", 3, np.int32)
    loops = _numbers(data.loop_triangles, "loops", 3, np.int32)
    world = np.array(obj.matrix_world, np.float64)
    # Vertices that are no numbers are passed on; sums with them are no numbers either, and that's no news.
    with np.errstate(invalid="ignore", over="ignore"):
        vertices = vertices.astype(np.float64) @ world[:3, :3].T + world[:3, 3]
    if np.linalg.det(world[:3, :3]) < 0:  # mirrored: what ran counter-clockwise runs clockwise
        triangles, loops = triangles[:, ::-1], loops[:, ::-1]
    return np.ascontiguousarray(vertices), np.ascontiguousarray(triangles), loops


def _numbers(items, attribute, width, kind):
    flat = np.empty(width * len(items), kind)
    items.foreach_get(attribute, flat)
    return flat.reshape(-1, width)


class Skin:
    """A surface's materials and UVs, to be put on pieces of it."""

    def __init__(self, obj, data, vertices, triangles, loops):
        self.corners = vertices[triangles]  # m x 3 x 3
        self.materials = [slot.material for slot in obj.material_slots]
        self.material_indices = _numbers(data.loop_triangles, "material_index", 1, np.int32).ravel()
        self.uvs = [(layer.name, _numbers(layer.data, "uv", 2, np.float32)[loops]) for layer in data.uv_layers]
        self.tree = BVHTree.FromPolygons(vertices.tolist(), triangles.tolist(), all_triangles=True)

    def dress(self, data, corners, source, reach):
        """Gives a part's mesh (`corners`, m x 3 x 3, where they stand in the target, world space) slots, UVs and indices.

        Triangles with a source, or where nothing has one those within `reach`, take the nearest triangle's; others
        are interfaces. `source` doesn't number this surface's own triangles: cleaning has renumbered them.
        """
        known = bool((source >= 0).any())
        outside = source >= 0 if known else np.ones(len(corners), bool)
        nearest = np.full(len(corners), -1)
        for index in np.flatnonzero(outside).tolist():
            _, _, hit, distance = self.tree.find_nearest(corners[index].mean(axis=0).tolist())
            if hit is not None and (known or distance < reach):
                nearest[index] = hit
        outside = nearest >= 0
        for material in self.materials or [None]:
            data.materials.append(material)
        data.materials.append(interface_material())
        indices = np.full(len(corners), max(1, len(self.materials)), np.int32)
        last = max(0, len(self.materials) - 1)
        indices[outside] = np.clip(self.material_indices[nearest[outside]], 0, last)
        data.polygons.foreach_set("material_index", indices)
        weights = _barycentric(self.corners[nearest[outside]], corners[outside])
        for name, uv in self.uvs:
            values = np.zeros((len(corners), 3, 2), np.float32)
            values[outside] = np.einsum("tck,tkd->tcd", weights, uv[nearest[outside]])
            layer = data.uv_layers.new(name=name, do_init=False)
            layer.data.foreach_set("uv", values.ravel())
        data.update()


def interface_material():
    """Of what was inside the target and shows when the design unfolds."""
    material = bpy.data.materials.get(INTERFACE_MATERIAL)
    if material is None:
        material = bpy.data.materials.new(INTERFACE_MATERIAL)
        material.diffuse_color = (0.35, 0.36, 0.38, 1.0)
    return material


def _barycentric(triangles, points):
    """Weights (m x 3 points x 3 corners) of points in their triangles' planes, none negative."""
    a, b, c = triangles[:, None, 0], triangles[:, None, 1], triangles[:, None, 2]
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    wu, wv = (w * u).sum(-1), (w * v).sum(-1)
    area = uu * vv - uv * uv
    area = np.where(area > 0, area, np.inf)  # of no area: the first corner's
    second, third = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
    weights = np.stack([1 - second - third, second, third], axis=-1).clip(0, 1)
    return weights / weights.sum(-1, keepdims=True)


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
