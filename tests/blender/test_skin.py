# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts show what the target showed: its materials and UVs outside, a material of their own at interfaces."""
import bpy
import numpy as np

import scenes
from transformables.bridge import mesh


def test_pieces_of_a_surface_get_its_materials_and_uvs_and_interfaces_their_own(empty_scene):
    target = scenes.cube("box", 2.0, (4, 5, 6))
    first, second = bpy.data.materials.new("first"), bpy.data.materials.new("second")
    target.data.materials.append(first)
    target.data.materials.append(second)
    for polygon in target.data.polygons:
        polygon.material_index = int(polygon.normal.x > 0.5)
    layer = target.data.uv_layers.active or target.data.uv_layers.new(name="UVMap")
    for polygon in target.data.polygons:  # UVs that tell the place: (y, z)
        for loop in polygon.loop_indices:
            co = target.data.vertices[target.data.loops[loop].vertex_index].co
            layer.data[loop].uv = (co.y, co.z)
    bpy.context.view_layer.update()
    # A piece of the face at x = +1, a piece of that at z = +1 (each within one triangle), and a triangle in the middle.
    local = np.array([[[1, -0.2, -0.9], [1, 0.2, -0.9], [1, 0.1, -0.65]], [[-0.2, -0.9, 1], [0.2, -0.9, 1], [0.1, -0.65, 1]],
                      [[0, 0, 0], [0, 0.3, 0], [0, 0, 0.3]]])
    half = max(v.co.x for v in target.data.vertices)
    corners = local * half + np.array(target.location)
    part = mesh.new_mesh("part", local.reshape(-1, 3), np.arange(9).reshape(3, 3))
    mesh.read_skin(bpy.context, target).dress(part, corners, np.array([7, 8, -1], np.int32), 0.01)
    assert [m.name for m in part.materials] == ["first", "second", mesh.INTERFACE_MATERIAL]
    assert [p.material_index for p in part.polygons] == [1, 0, 2]
    uvs = np.array([tuple(d.uv) for d in part.uv_layers[0].data]).reshape(3, 3, 2)
    assert np.allclose(uvs[:2], (local * half)[:2, :, 1:], atol=1e-5)
    assert (uvs[2] == 0).all()
