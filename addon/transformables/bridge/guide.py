# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide: a copy of the character, as large as it is in the target and folded, for artists to pose by hand. Never their own rig."""
from array import array
import json

import bpy
from mathutils import Vector

from ..core.options import UserError
from . import animation, armature, rig

ROLE = "guide"


def of(scene, character_obj):
    """The scene's guide for this character, or None."""
    return next((o for o in scene.objects if o.get("transformable_role") == ROLE and o.get("transformable_source") == character_obj.name), None)


def make(context, character_obj, limit, made_with, embedding):
    """The guide in its folded pose, in an older one's place. `made_with`: "character" and "target" of the result that the pose came
    with; `limit`: most bones, as for the design. @raises UserError when the character is not what it was"""
    character = armature.read_character(character_obj, limit)
    if character.names != made_with["character"]["names"]:
        raise UserError(f"'{character_obj.name}' has changed since its folded pose was found: find it again")
    remove(context.scene, character_obj)
    arrays = {name: ("d", array("d", getattr(character, name)).tobytes()) for name in ("heads", "tails", "axes", "rotation")}
    result = {**made_with, "embedding": embedding}
    layout = rig.Layout(result, arrays)
    guide = rig.new_rig(context, f"{character_obj.name} pose", layout, context.scene.collection, Vector(made_with["target"]["centre"]))
    guide["transformable_role"] = ROLE
    guide["transformable_source"] = character_obj.name
    guide["transformable_guide"] = json.dumps({**made_with, "embedding": embedding})
    for body, hinges in enumerate(layout.hinges):
        for offset, (axis, _, _) in enumerate(hinges):
            guide.pose.bones[layout.lead(body)].rotation_euler[axis] = embedding["angles"][layout.first_angle[body] + offset]
    root = guide.pose.bones[layout.lead(0)]
    location, (axis, angle) = animation.root_basis(guide, layout, result)
    root.location, root.rotation_axis_angle = location, (angle, *axis)
    context.view_layer.update()
    return guide


def read(context, guide):
    """The pose that the guide is in, as an embedding to search from. @raises UserError when a bone is missing"""
    made = json.loads(guide["transformable_guide"])
    character, target, embedding = made["character"], made["target"], made["embedding"]
    context.view_layer.update()
    angles = list(embedding["angles"])
    for body, hinges in enumerate(character["hinges"]):
        turned = _turned(_pose_bone(guide, character, body)) if hinges else ()
        for offset, (axis, _, _) in enumerate(hinges):
            angles[character["first_angle"][body] + offset] = turned[axis]
    changed = max((abs(a - b) for a, b in zip(angles, embedding["angles"])), default=0.0) > 1e-4
    return {"root": _root(guide, _pose_bone(guide, character, 0), target), "angles": angles, "morphology": embedding["morphology"],
            "symmetric": embedding["symmetric"] and not changed}


def remove(scene, character_obj):
    guide = of(scene, character_obj)
    if guide is not None:
        rig.remove(guide)


def _pose_bone(guide, character, body):
    name = character["names"][character["members"][body][0]]
    if name not in guide.pose.bones:
        raise UserError(f"'{guide.name}' has lost its bone '{name}': make the pose rig again")
    return guide.pose.bones[name]


def _turned(pose_bone):
    if pose_bone.rotation_mode == "XYZ":
        return tuple(pose_bone.rotation_euler)
    return tuple(pose_bone.matrix_basis.to_euler("XYZ"))


def _root(guide, pose_bone, target):
    """The root bone's frame in the target's, 16 numbers column by column."""
    world = guide.matrix_world @ pose_bone.matrix
    head = (world.to_translation() - Vector(target["centre"])) * target["scale"]
    columns = armature.orthonormal(world.to_3x3())
    flat = [x for column in zip(*columns) for x in (*column, 0.0)]
    return [*flat, *head, 1.0]
