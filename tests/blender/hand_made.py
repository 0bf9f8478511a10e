# SPDX-License-Identifier: GPL-3.0-or-later
"""A result made by hand, as a worker would give it, and what Blender makes of it.

The folded pose here is made up, and the parts are boxes: what is tested is that Blender shows exactly what was said.
"""
import itertools
import math

import bpy
from mathutils import Matrix, Quaternion
import numpy as np
import pytest
import scenes
from transformables.bridge import design
from transformables.core.options import DesignOptions

FIT, UNITS = 0.4, 0.25  # target units for one unit of the armature; for one Blender unit
BOX = np.array(list(itertools.product((-0.01, 0.01), (0.0, 0.05), (-0.02, 0.02))))
BOX_FACES = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
                      (1, 5, 7), (1, 7, 3)], np.int32)
ROOT = Matrix.Translation((0.03, -0.02, 0.05)) @ Quaternion((0.3, 0.5, -0.7, 0.4)).normalized().to_matrix().to_4x4()


def hand_made(character_obj, target_obj, options):
    """(result, arrays) as a worker would give them, for a made-up folded pose."""
    message, arrays = design.gather(character_obj, target_obj, options)
    names, parents, hinges = (message["character"][k] for k in ("names", "parents", "hinges"))
    bodies, members = {}, []
    for i in range(len(names)):  # a bone without hinges is one body with its parent
        if parents[i] >= 0 and not hinges[i]:
            bodies[i] = bodies[parents[i]]
            members[bodies[i]].append(i)
        else:
            bodies[i] = len(members)
            members.append([i])
    body_hinges = [hinges[m[0]] for m in members]
    first = [sum(len(h) for h in body_hinges[:i]) for i in range(len(members))]
    count = sum(len(h) for h in body_hinges)
    angles = [0.9 * (hinge[2] if i % 2 else hinge[1]) for i, hinge in enumerate(h for hs in body_hinges for h in hs)]
    moves = [[(0, angles[0], 0.0), (1, angles[1], 0.0)]] + [[(i, angles[i], 0.0)] for i in range(2, count)]
    moves.append([])  # a move of nothing must do no harm
    result = {
        "until": "finishing", "stopped": False, "options": options.as_dict(), "native_version": "none", "seconds": {"total": 1.0}, "warnings": [],
        "peak_memory_mb": 1.0, "names": message["names"],
        "character": {"names": names, "parents": parents, "bodies": [names[m[0]] for m in members], "members": members,
                      "body_parents": [bodies[parents[m[0]]] if parents[m[0]] >= 0 else -1 for m in members],
                      "hinges": body_hinges, "first_angle": first, "angle_count": count, "mirrored": False, "scale": FIT},
        "target": {**message["target"], "scale": UNITS, "centre": list(target_obj.location), "volume": 0.1, "grid": [64] * 3, "mirror_axis": None},
        "embedding": {"root": [ROOT[r][c] for c in range(4) for r in range(4)], "angles": angles,
                      "morphology": [0.8 + 0.05 * i for i in range(len(members))], "terms": {"total": 1.0}, "symmetric": False},
        "path": {"moves": moves, "collisions": [], "overlap_volume": 0.0},
        "finishing": {"parts": [{"bone": i, "volume": 1e-5} for i in range(len(members))], "preview": False, "collisions": [],
                      "minimum_clearance": 0.001, "carved_volume_pct": 0.0, "filled_volume_pct": 99.0, "pinned": [],
                      "certificate": {"holds": True, "gap": 0.001, "open": []}}}
    out = {name: arrays[name] for name in ("heads", "tails", "axes", "rotation")}
    for i in range(len(members)):
        out[f"part_{i}_vertices"] = ("d", BOX.astype(np.float64).tobytes())
        out[f"part_{i}_triangles"] = ("i", BOX_FACES.tobytes())
    return result, out


@pytest.fixture
def scene(empty_scene):
    character = scenes.placed(scenes.walker(), rotation=(0, 10, 70), location=(-3, 4, 1), scale=(2, 2, 2))
    target = scenes.cube("box", 2.0, (4, 5, 6))
    return character, target


@pytest.fixture
def made(scene):
    options = DesignOptions()
    result, arrays = hand_made(*scene, options)
    return {**design.apply(bpy.context, result, arrays, *scene, options), "result": result, "arrays": arrays,
            "character": scene[0], "target": scene[1]}


def at(frame):
    whole = math.floor(frame + 1e-9)
    bpy.context.scene.frame_set(whole, subframe=min(max(frame - whole, 0.0), 0.9999))
    return bpy.context.evaluated_depsgraph_get()


def world_of_bones(rig, frame):
    evaluated = rig.evaluated_get(at(frame))
    return {b.name: evaluated.matrix_world @ b.matrix for b in evaluated.pose.bones}


def samples(made, step=1.5):
    return np.arange(1, made["schedule"].last_frame + 1e-6, step)
