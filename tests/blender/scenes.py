# SPDX-License-Identifier: GPL-3.0-or-later
"""Small characters and targets for the tests inside Blender."""
import math

import bpy
from mathutils import Matrix, Vector

X_ONLY = {"lock_ik_y": True, "lock_ik_z": True, "use_ik_limit_x": True, "ik_min_x": -2.5, "ik_max_x": 2.5}


def armature(rows, name="creature"):
    """An armature from (name, parent, head, tail, roll in degrees, pose bone settings)."""
    data = bpy.data.armatures.new(name)
    obj = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    for bone_name, parent, head, tail, roll, _ in rows:
        bone = data.edit_bones.new(bone_name)
        bone.head, bone.tail, bone.roll = head, tail, math.radians(roll)
        bone.parent = data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone_name, _, _, _, _, settings in rows:
        for key, value in (settings or {}).items():
            setattr(obj.pose.bones[bone_name], key, value)
    return obj


def limit_rotation(pose_bone, space="LOCAL", **ranges):
    """Adds a Limit Rotation constraint; ranges: x=(least, largest) in degrees."""
    constraint = pose_bone.constraints.new("LIMIT_ROTATION")
    constraint.owner_space = space
    for letter, (least, largest) in ranges.items():
        setattr(constraint, f"use_limit_{letter}", True)
        setattr(constraint, f"min_{letter}", math.radians(least))
        setattr(constraint, f"max_{letter}", math.radians(largest))
    return constraint


def walker():
    """A trunk with a two-joint leg each side (offset heads, rolls, one bone fixed to its parent) and a two-hinge head."""
    leg = [(f"{part}.{side}", parent, head, tail, 25 * sign, settings) for side, sign in (("L", 1), ("R", -1))
           for part, parent, head, tail, settings in (
               ("thigh", "trunk", (0.2 * sign, 0.1, 1), (0.3 * sign, 0.2, 0.5), X_ONLY),
               ("shin", f"thigh.{side}", (0.3 * sign, 0.2, 0.5), (0.3 * sign, 0.1, 0), X_ONLY),
               ("foot", f"shin.{side}", (0.3 * sign, 0.1, 0), (0.3 * sign, -0.1, 0),
                {"lock_ik_x": True, "lock_ik_y": True, "lock_ik_z": True}))]
    head = ("head", "trunk", (0, 0.05, 1.6), (0, 0.2, 1.9), 10, {"lock_ik_y": True, "use_ik_limit_x": True, "ik_min_x": -1.5,
                                                                  "ik_max_x": 1.5, "use_ik_limit_z": True, "ik_min_z": -1.0, "ik_max_z": 1.0})
    return armature([("trunk", None, (0, 0, 1), (0, 0.1, 1.5), 0, None), *leg, head], "walker")


def cube(name="box", size=2.0, location=(0, 0, 0)):
    half = size / 2
    vertices = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh_object(name, vertices, faces, location)


def mesh_object(name, vertices, faces, location=(0, 0, 0)):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    obj.location = Vector(location)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def placed(obj, rotation=(0, 0, 0), location=(0, 0, 0), scale=(1, 1, 1)):
    obj.rotation_euler, obj.location, obj.scale = [math.radians(a) for a in rotation], location, scale
    bpy.context.view_layer.update()
    return obj


def close(a, b, tolerance=1e-5):
    return max(abs(x - y) for row, other in zip(Matrix(a), Matrix(b)) for x, y in zip(row, other)) < tolerance
