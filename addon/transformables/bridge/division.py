# SPDX-License-Identifier: GPL-3.0-or-later
"""The division of the target's surface among the bones, from a result into the scene and back: a mesh without an object, in the target's own space,
with the index of its part at each vertex. It is undone and saved with the scene, and is drawn where a seam is dragged."""
import time

import numpy as np

import bpy

from . import mesh

PART = "part"         # the attribute: an index into `bodies`, or -1
BODIES = "bodies"     # custom property: names of the character's bodies, one a line
DRAGGED = "dragged"   # custom property: when a seam was last dragged; not there: the division is as it was made


def store(stage, result, arrays, target_obj):
    """Keeps a result's division in the scene (`stage`: the segmentation's settings), in the older one's place."""
    triangles = np.frombuffer(arrays["division_triangles"][1], np.int32).reshape(-1, 3)
    into = np.array(target_obj.matrix_world.inverted_safe())
    vertices = np.frombuffer(arrays["division_vertices"][1]).reshape(-1, 3) @ into[:3, :3].T + into[:3, 3]
    if np.linalg.det(into[:3, :3]) < 0:  # mirrored: what ran counter-clockwise runs clockwise
        triangles = triangles[:, ::-1]
    data = mesh.new_mesh(f"{target_obj.name} division", vertices, triangles)
    data.attributes.new(PART, "INT", "POINT")
    data[BODIES] = "\n".join(result["character"]["bodies"])
    _write(data, np.frombuffer(arrays["division_bones"][1], np.int32))
    older, stage.division = stage.division, data
    if older is not None and older.users == 0:
        bpy.data.meshes.remove(older)


def read(data):
    """Vertices (float64, n x 3) in the target's own space, triangles (int32, m x 3), each vertex' part (int32, n; -1: none)."""
    vertices, triangles = np.empty(3 * len(data.vertices), np.float32), np.empty(3 * len(data.polygons), np.int32)
    data.vertices.foreach_get("co", vertices)
    data.polygons.foreach_get("vertices", triangles)
    parts = np.empty(len(data.vertices), np.int32)
    data.attributes[PART].data.foreach_get("value", parts)
    return vertices.astype(np.float64).reshape(-1, 3), triangles.reshape(-1, 3), parts


def body(data, name):
    """The index that the attribute has for a body."""
    return data[BODIES].split("\n").index(name)


def keep_dragged(data, parts):
    """Writes whose each vertex is after a seam was dragged."""
    _write(data, parts)
    data[DRAGGED] = time.time()


def _write(data, parts):
    data.attributes[PART].data.foreach_set("value", np.ascontiguousarray(parts, np.int32))
    data.update()
