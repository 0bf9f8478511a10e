# SPDX-License-Identifier: GPL-3.0-or-later
"""The bridge's door, for the panel and the headless command alike: gather a job from objects, apply its result."""
from array import array
import json

import bpy
import numpy as np

from ..core import blocks, kinematics, report, schedule
from ..core.options import UserError
from . import animation, armature, mesh, printing, rig
from . import edits as edit_list

VERSION = "0.1.0"
REMESHED_WITHIN = 0.003  # target units from the target's surface: a re-meshed part's face is an outer one
SINGLE = 2.0 ** -23  # what Blender's numbers are rounded to, of their size
ROUGH = 1e-4  # of the target's longest side: places that are rounded to more than that show
SMALLEST_SIDE = 1e-3  # Blender units: it deletes bones that are shorter than a millionth


def gather(character_obj, target_obj, options, until="finishing", embedding=None, path=None, start=None, steering=None, explore=None,
           rival=None, context=None, edits=()):
    """A job's message and arrays (core/pipeline.py) from two objects; nothing in the scene changes.

    `embedding` and `path` as an earlier result gave them are not searched again; `start` is a folded pose to search from; `rival` one that
    a search has to beat;
    `steering` and `explore` as core/pipeline.py has them; `edits` are the artist's edits of the segmentation, as bridge/edits.py gathers them.
    Raises UserError. A message holds names and numbers only, no reference to Blender's data.
    """
    context = context or bpy.context
    options.validate()
    for obj, kind, words in ((character_obj, "ARMATURE", "an armature"), (target_obj, "MESH", "a mesh")):
        if obj is None or obj.type != kind:
            raise UserError(f"'{obj.name if obj else 'nothing'}' is not {words}: pick {words} object")
    context.view_layer.update()  # a script may have moved objects just now
    character = armature.read_character(character_obj, options.bone_limit())
    vertices, triangles = mesh.read_triangles(context, target_obj)
    box = mesh.bounds(vertices, triangles)
    if box is not None and 0 < max(box[1] - box[0]) < SMALLEST_SIDE:
        raise UserError(f"the target '{target_obj.name}' is only {max(box[1] - box[0]):.2g} Blender units long, too small for "
                        "Blender's bones: scale it up")
    warnings = [*character.warnings, *_told_of_distance(target_obj.name, box)]
    message = {
        "kind": "design", "until": until, "options": options.as_dict(),
        "names": {"character": character_obj.name, "target": target_obj.name},
        "character": {"names": character.names, "parents": character.parents, "hinges": character.hinges},
        "target": {"floor": float(box[0][2]) if box else 0.0}, "warnings": warnings,
        "stored": {"embedding": embedding, "path": path, "start": start, "rival": rival},
        "steering": steering or {}, "explore": explore}
    arrays = {"heads": ("d", character.heads.tobytes()), "tails": ("d", character.tails.tobytes()),
              "axes": ("d", character.axes.tobytes()), "rotation": ("d", character.rotation.tobytes()),
              "vertices": ("d", vertices.tobytes()), "triangles": ("i", triangles.tobytes())}
    message["edits"], painted = edit_list.gather(edits, context, target_obj)
    arrays.update(painted)
    return message, arrays


def _told_of_distance(name, box):
    """A warning where the target lies so far out that Blender's single precision shows; no matter how large it is.

    `box` as from `mesh.bounds`.
    """
    if box is None:
        return []
    reach = np.abs(box).max()
    if SINGLE * reach <= ROUGH * max(box[1] - box[0]):
        return []
    return [f"the target '{name}' lies {reach:.3g} units from the world's origin, very far for its size: Blender's numbers are rough "
            "there and parts may stand a little off. Move it nearer"]


def apply(context, result, arrays, character_obj, target_obj, options):
    """Makes the result's objects in the scene, in the older result's place if there is one.

    Gives {"collection", "rig", "parts", "action", "schedule", "in_the_way" (rows of core/blocks.py), "report"}. Inputs get the contract's marks, and the
    target is hidden; nothing else of them changes.
    """
    layout = rig.Layout(result, arrays)
    parts = rig.part_arrays(result, arrays, layout)
    angles = result["embedding"]["angles"]
    moves = result["path"]["moves"] if result["path"] else schedule.together(angles)
    schedule.check_path(moves, angles)
    plan = schedule.scheduled(moves, options.frames)
    collection = rig.result_collection(context, character_obj, target_obj)
    new_rig = rig.new_rig(context, f"{character_obj.name} rig", layout, collection, rig.standing_place(layout, parts, result))
    rig.mark(new_rig, character_obj, target_obj)
    objects = rig.new_parts(new_rig, layout, parts, collection, [])
    _dress(context, objects, parts, result, arrays, layout, target_obj)
    action = animation.new_fold(new_rig, layout, plan, result)
    animation.add_slider(new_rig, action, plan.last_frame)
    new_rig[printing.MM] = options.millimetres(result["target"]["scale"])
    new_rig[printing.PINS] = len(result["finishing"]["pinned"]) if result["finishing"] else 0
    new_rig["transformable_stored"] = json.dumps({key: result[key] for key in ("options", "embedding", "path")})
    scene = context.scene
    animation.play(scene, new_rig, plan, options.loop)
    scene.frame_set(schedule.FIRST_FRAME)
    rows = blocks.blocks(result, plan)
    return {"collection": collection, "rig": new_rig, "parts": objects, "action": action, "schedule": plan, "in_the_way": rows,
            "report": report.build(result, plan, VERSION, bpy.app.version_string, rows)}


def retimed(scene, rig, options):
    """Gives the fold of a rig that `apply` made the length and the loop of these options. Gives its schedule. Raises UserError."""
    stored = json.loads(rig["transformable_stored"])
    before = stored["options"]
    moves = stored["path"]["moves"] if stored["path"] else schedule.together(stored["embedding"]["angles"])
    if animation.fold_of(rig) is None:
        raise UserError(f"'{rig.name}' has lost its fold: make the design again")
    plan = schedule.scheduled(moves, options.frames)
    animation.retime(rig, schedule.scheduled(moves, before["frames"]), plan)
    animation.play(scene, rig, plan, options.loop)
    before.update(frames=options.frames, loop=options.loop)
    rig["transformable_stored"] = json.dumps(stored)
    return plan


def _dress(context, objects, parts, result, arrays, layout, target_obj):
    """The target's materials and UVs on the parts, which are pieces of it; interfaces get a material of their own."""
    if not parts:
        return
    skin = mesh.read_skin(context, target_obj)
    frames = _folded_frames(result, arrays, layout)
    for index, (obj, (body, vertices, triangles)) in enumerate(zip(objects, parts)):
        rotation, head = frames[body]
        source = arrays.get(f"part_{index}_source")  # results made by older versions have none
        source = np.frombuffer(source[1], np.int32) if source else np.full(len(triangles), -1, np.int32)
        skin.dress(obj.data, (vertices @ rotation.T + head)[triangles], source, REMESHED_WITHIN * layout.unit)


def _folded_frames(result, arrays, layout):
    """Each body's rotation and head in object mode, world space: where the parts make up the target."""
    character, target, embedding = result["character"], result["target"], result["embedding"]
    skeleton = kinematics.Skeleton(layout.members, character["body_parents"], layout.hinges, layout.first_angle,
                                   *(array("d", bytes(arrays[name][1])) for name in ("heads", "tails", "axes")))
    root = embedding["root"]
    rotation = tuple(tuple(root[4 * c + r] for c in range(3)) for r in range(3))
    head = tuple(root[12 + r] * layout.unit + target["centre"][r] for r in range(3))
    frames = skeleton.frames(rotation, head, embedding["angles"], embedding["morphology"], character["scale"] * layout.unit)
    return [(np.array(r), np.array(h)) for r, h in frames]
