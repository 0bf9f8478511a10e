# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells whether a stored result still belongs to what is in the scene.

Two strengths: `quick` is cheap enough for every redraw of the panel (names, bones, counts, sizes, options);
`thorough` also reads every vertex, and is what decides whether a stored result is used again.
"""

import hashlib
import json

import numpy as np

import bpy

from ..bridge.edits import PAINTED
from ..bridge.mesh import IN_GROUP, read_triangles
from . import settings, steering

_LOCKS = ("lock_ik_x", "lock_ik_y", "lock_ik_z", "use_ik_limit_x", "use_ik_limit_y", "use_ik_limit_z",
          "ik_min_x", "ik_min_y", "ik_min_z", "ik_max_x", "ik_max_y", "ik_max_z")
_LIMITS = ("use_limit_x", "use_limit_y", "use_limit_z", "min_x", "min_y", "min_z", "max_x", "max_y", "max_z", "owner_space", "mute")


def _rounded(values):
    return [round(float(value), 5) for value in values]


def _turn(matrix):
    """Rotation and uneven scale: a target frame is centred and of one size, so place and even scale do not matter."""
    turn = np.array(matrix.to_3x3())
    return _rounded((turn / max(np.abs(turn).max(), 1e-12)).flat)


def _bone(bone, pose_bone):
    limits = [[getattr(constraint, name) for name in _LIMITS] for constraint in pose_bone.constraints if constraint.type == "LIMIT_ROTATION"]
    return [bone.name, bone.parent.name if bone.parent else "", _rounded(bone.head_local), _rounded(bone.tail_local),
            _rounded(bone.matrix_local.col[0]), [getattr(pose_bone, name) for name in _LOCKS], limits]


def _character(obj):
    return [obj.name, _turn(obj.matrix_world), [_bone(bone, obj.pose.bones[bone.name]) for bone in obj.data.bones if bone.name in obj.pose.bones]]


def _target(obj, thorough):
    rows = [obj.name, _turn(obj.matrix_world), len(obj.data.vertices), len(obj.data.polygons), _rounded(v for c in obj.bound_box for v in c)]
    if thorough:
        rows += _mesh(obj)
    return rows


def _mesh(obj):
    """Every vertex and triangle as a design reads them, but in the object's own space: where it stands does not matter."""
    vertices, triangles = read_triangles(bpy.context, obj)
    world = np.array(obj.matrix_world, np.float64)
    if np.linalg.det(world[:3, :3]) != 0:
        vertices = (vertices - world[:3, 3]) @ np.linalg.inv(world[:3, :3]).T
    # Single precision, as Blender keeps them: that takes the rounding of the way there and back away.
    return [hashlib.sha256(np.ascontiguousarray(a).tobytes()).hexdigest() for a in (vertices.astype(np.float32), triangles)]


def _edits(scene, target, thorough):
    """The edits that are switched on; `thorough` also reads what is painted."""
    rows = []
    for edit in settings.edits(scene):
        rows.append([edit.kind, edit.bone, edit.other, edit.group, round(edit.thickness_mm, 4), edit.points])
        if thorough and edit.kind in PAINTED and target is not None:
            rows.append(hashlib.sha256(_painted(target, edit.group).tobytes()).hexdigest())
    return rows


def _painted(obj, group):
    """Which vertices are painted, before modifiers: where the object stands does not matter."""
    index = obj.vertex_groups.find(group)
    return np.fromiter((any(g.group == index and g.weight >= IN_GROUP for g in v.groups) for v in obj.data.vertices), bool, len(obj.data.vertices))


def _inputs(scene, stage, thorough):
    s = scene.transformables
    character, target = settings.picked(scene, "character"), settings.picked(scene, "target")
    rows = [stage]
    if stage != "target" and character is not None:
        rows += [_character(character), s.character_stage.simplify, s.character_stage.simplify_count, s.character_stage.fit]
    if stage != "character" and target is not None:
        rows += [_target(target, thorough), s.target_stage.resolution]
    if stage in ("embedding", "segmentation", "folding"):
        rows += [s.embedding_stage.seed, s.embedding_stage.symmetry, s.embedding_stage.proportions, steering.inputs(scene)]
    if stage == "folding":
        rows.append(round(s.folding_stage.seconds, 3))
    if stage in ("segmentation", "folding"):
        rows += _edits(scene, target, thorough)
        rows += [s.segmentation_stage.transfer, round(s.target_stage.size_mm, 4), round(s.finishing_stage.clearance_mm, 4)]
    return rows


def _digest(rows):
    return hashlib.sha256(json.dumps(rows).encode()).hexdigest()[:16]


def take(scene, stage):
    """What to keep beside a stored result of this stage."""
    return json.dumps({"quick": _digest(_inputs(scene, stage, False)), "thorough": _digest(_inputs(scene, stage, True))})


def fits(scene, stage, kept, thorough=False):
    """Whether a result kept with this fingerprint still belongs to the scene's inputs. False when nothing is kept."""
    if not kept:
        return False
    strength = "thorough" if thorough else "quick"
    return json.loads(kept)[strength] == _digest(_inputs(scene, stage, thorough))
