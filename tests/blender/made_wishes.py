# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of wishes share: what is gathered of them, and how the parts came out."""
import bpy
from mathutils.bvhtree import BVHTree


def gathered():
    from transformables.bridge import edits
    from transformables.ui import settings
    return edits.gather(settings.edits(bpy.context.scene), bpy.context, bpy.data.objects["Box"])


def parts_in_object_mode():
    """A tree of the triangles of every part, by its bone, where it stands when all is folded."""
    scene = bpy.context.scene
    scene.frame_set(scene.frame_end)
    depsgraph, trees = bpy.context.evaluated_depsgraph_get(), {}
    for obj in bpy.data.objects:
        if obj.get("transformable_role") == "part":
            world = obj.evaluated_get(depsgraph).matrix_world
            trees[obj["transformable_bone"]] = BVHTree.FromPolygons([world @ v.co for v in obj.data.vertices], [p.vertices[:] for p in obj.data.polygons])
    return trees
