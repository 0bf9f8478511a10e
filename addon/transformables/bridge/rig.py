# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the result's objects: a collection with the rig, its bones scaled, and the parts, each parented to its bone."""
from array import array
import colorsys

import bpy
from mathutils import Matrix, Vector
import numpy as np

from ..core import kinematics
from . import animation, mesh

LETTERS = "xyz"
REST_TOLERANCE = 1e-3  # of a rotation matrix's elements: Blender stores rest frames as a direction and a roll


class Layout:
    """Where everything of a result stands in character mode; Blender units, world axes, the root's head at the origin."""

    def __init__(self, result, arrays):
        character, target = result["character"], result["target"]
        flat = {name: array("d", bytes(arrays[name][1])) for name in ("heads", "tails", "axes", "rotation")}
        self.names, self.armature_parents = character["names"], character["parents"]
        self.bodies, self.members = character["bodies"], character["members"]
        self.hinges, self.first_angle = character["hinges"], character["first_angle"]
        self.unit = 1.0 / target["scale"]                 # Blender units for one target unit
        self.morphology = result["embedding"]["morphology"]
        lengths = character["scale"] * self.unit
        skeleton = kinematics.Skeleton(self.members, character["body_parents"], self.hinges, self.first_angle,
                                       flat["heads"], flat["tails"], flat["axes"])
        self.axes = [Matrix(m) for m in skeleton.axes]
        self.object_rotation = Matrix(kinematics.matrix_of(flat["rotation"]))
        rest = [0.0] * character["angle_count"]
        frames = skeleton.frames(skeleton.axes[self.members[0][0]], (0.0, 0.0, 0.0), rest, self.morphology, lengths)
        self.frames = [(np.array(rotation), np.array(head)) for rotation, head in frames]
        self.ends = sorted((bone, head, self._tail(bone, head, tail))
                           for bone, head, tail in skeleton.bone_ends(frames, self.morphology, lengths))

    def _tail(self, bone, head, tail):
        """On the bone's own Y axis, as Blender has it: the link of a simplified bone may end beside it."""
        link = Vector(tail) - Vector(head)
        along = self.axes[bone].col[1]
        return tuple(Vector(head) + along * (link.dot(along) if link.dot(along) > 0.1 * link.length else link.length))

    def lead(self, body):
        """Name of the bone that a body's parts hang on."""
        return self.names[self.members[body][0]]


def part_arrays(result, arrays, layout):
    """The parts' meshes in Blender units, bone frame: [(body, vertices, triangles), ...]."""
    parts = []
    for index, part in enumerate(result["finishing"]["parts"] if result["finishing"] else []):
        vertices = np.frombuffer(arrays[f"part_{index}_vertices"][1], np.float64).reshape(-1, 3) * layout.unit
        triangles = np.frombuffer(arrays[f"part_{index}_triangles"][1], np.int32).reshape(-1, 3)
        parts.append((part["bone"], vertices, triangles))
    return parts


def standing_place(layout, parts, result):
    """World position of the root's head in character mode: over the target's centre, feet on the target's floor."""
    if parts:
        lowest = min((vertices @ layout.frames[body][0].T + layout.frames[body][1])[:, 2].min() for body, vertices, _ in parts)
    else:
        lowest = min(min(head[2], tail[2]) for _, head, tail in layout.ends)
    centre = result["target"]["centre"]
    return Vector((centre[0], centre[1], result["target"]["floor"] - lowest))


def new_rig(context, name, layout, collection, place):
    """The rig: the character's bones with their names, hierarchy and rest angles, and the design's lengths."""
    data = bpy.data.armatures.new(name)
    rig = bpy.data.objects.new(name, data)
    collection.objects.link(rig)
    rig.matrix_world = Matrix.Translation(place) @ layout.object_rotation.to_4x4()
    _edit(context, rig, lambda: _add_bones(data, layout))
    worst = max(abs(a - b) for bone, _, _ in layout.ends
                for row, wanted in zip(data.bones[layout.names[bone]].matrix_local.to_3x3(), _rest(layout, bone))
                for a, b in zip(row, wanted))
    if worst > REST_TOLERANCE:
        raise RuntimeError(f"a bone of the rig came out turned by {worst:.2g} against the character's")
    _set_joints(rig, layout)
    data.display_type = "STICK"
    rig.show_in_front = True
    return rig


def _edit(context, rig, work):
    """Bones can only be made in Edit Mode."""
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for obj in context.selected_objects:
        obj.select_set(False)
    rig.select_set(True)
    context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        work()
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def _rest(layout, bone):
    return layout.object_rotation.transposed() @ layout.axes[bone]


def _add_bones(data, layout):
    to_armature = layout.object_rotation.transposed()
    made = {}
    for bone, head, tail in layout.ends:
        edit_bone = data.edit_bones.new(layout.names[bone])
        edit_bone.head, edit_bone.tail = to_armature @ Vector(head), to_armature @ Vector(tail)
        _, edit_bone.roll = bpy.types.Bone.AxisRollFromMatrix(_rest(layout, bone), axis=edit_bone.tail - edit_bone.head)
        made[bone] = edit_bone
    for bone, edit_bone in made.items():
        if layout.armature_parents[bone] >= 0:
            edit_bone.parent = made[layout.armature_parents[bone]]
            edit_bone.use_connect = False


def _set_joints(rig, layout):
    """What can't turn is locked, and limits are told to Blender's IK, so that artists pose within them."""
    leads = {members[0]: body for body, members in enumerate(layout.members)}
    for bone, _, _ in layout.ends:
        pose_bone = rig.pose.bones[layout.names[bone]]
        root = layout.armature_parents[bone] < 0
        pose_bone.rotation_mode = "AXIS_ANGLE" if root else "XYZ"
        if root:
            continue
        pose_bone.lock_location = pose_bone.lock_scale = (True, True, True)
        hinges = {axis: (least, largest) for axis, least, largest in layout.hinges[leads[bone]]} if bone in leads else {}
        pose_bone.lock_rotation = [axis not in hinges for axis in range(3)]
        for axis, letter in enumerate(LETTERS):
            setattr(pose_bone, f"lock_ik_{letter}", axis not in hinges)
        for axis, (least, largest) in hinges.items():
            setattr(pose_bone, f"use_ik_limit_{LETTERS[axis]}", True)
            setattr(pose_bone, f"ik_min_{LETTERS[axis]}", least)
            setattr(pose_bone, f"ik_max_{LETTERS[axis]}", largest)


def body_color(body):
    """By which a part is told from others (RGBA)."""
    return (*colorsys.hsv_to_rgb((0.61803 * body) % 1.0, 0.55, 0.9), 1.0)


def new_parts(rig, layout, parts, collection, materials):
    """A mesh object a part; its origin and axes are those of its bone."""
    objects = []
    for body, vertices, triangles in parts:
        bone = layout.lead(body)
        obj = bpy.data.objects.new(f"{bone} part", mesh.new_mesh(f"{bone} part", vertices, triangles))
        for material in materials:
            obj.data.materials.append(material)
        collection.objects.link(obj)
        obj.parent, obj.parent_type, obj.parent_bone = rig, "BONE", bone
        # A bone's children hang on its tail; back to its head, where the part's own frame is.
        obj.matrix_parent_inverse = Matrix.Translation((0.0, -rig.data.bones[bone].length, 0.0))
        obj.color = body_color(body)
        obj["transformable_role"] = "part"
        obj["transformable_bone"] = bone
        objects.append(obj)
    return objects


def mark(rig, character_obj, target_obj):
    """The contract's marks, and the target out of sight: the parts stand in its place."""
    rig["transformable_role"] = "rig"
    rig["transformable_source"] = character_obj.name
    rig["transformable_target"] = target_obj.name
    character_obj["transformable_role"] = "character"
    target_obj["transformable_role"] = "target"
    target_obj.hide_viewport = target_obj.hide_render = True


def result_collection(context, character_obj, target_obj):
    """Where the result goes: the older result's collection, emptied of it, or a new one."""
    collection = None
    for rig in [o for o in bpy.data.objects if _is_result(o, character_obj, target_obj)]:
        collection = rig.users_collection[0] if rig.users_collection else collection
        animation.unmark(context.scene, rig)
        remove(rig)
    if collection is None or collection == context.scene.collection:
        collection = bpy.data.collections.new(f"{character_obj.name} as {target_obj.name}")
        context.scene.collection.children.link(collection)
    return collection


def _is_result(obj, character_obj, target_obj):
    return (obj.get("transformable_role") == "rig" and obj.get("transformable_source") == character_obj.name
            and obj.get("transformable_target") == target_obj.name)


def remove(rig):
    action = rig.animation_data.action if rig.animation_data else None
    for part in [o for o in bpy.data.objects if o.parent == rig and o.get("transformable_role") == "part"]:
        data = part.data
        bpy.data.objects.remove(part)
        if data.users == 0:
            bpy.data.meshes.remove(data)
    data = rig.data
    bpy.data.objects.remove(rig)
    if data.users == 0:
        bpy.data.armatures.remove(data)
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)
