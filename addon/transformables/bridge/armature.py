# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a character from an armature object: bones in world coordinates, hinges by the contract's four rules."""
from array import array
from dataclasses import dataclass, field, replace
import math

from mathutils import Matrix

from ..core import simplify
from ..core.options import UserError

DEFAULT_RANGE = (-math.pi / 2, math.pi / 2)
NO_RANGE = math.radians(0.01)  # a range under this is a lock
LETTERS = "xyz"


@dataclass
class Character:
    """Plain lists; bone i's parent comes before it. Hinges: (axis, least, largest) in radians."""

    name: str
    names: list
    parents: list
    hinges: list
    heads: array
    tails: array
    axes: array          # nine numbers a bone, rows of the matrix whose columns are the bone's axes
    rotation: array      # of the armature object, row by row: world from armature space
    warnings: list = field(default_factory=list)
    left_out: list = field(default_factory=list)


@dataclass
class Bone:
    """A bone of the character; head, tail and axes in world coordinates."""

    name: str
    parent: object      # its name, or None
    head: tuple
    tail: tuple
    axes: tuple
    hinges: list
    explicit: bool      # its hinges were set by hand
    deform: bool


def read_character(obj, limit=None):
    """The character of an armature object, with at most `limit` bones (None: all). @raises UserError"""
    rotation = _rotation_of(obj)
    if not obj.data.bones:
        raise UserError(f"the armature '{obj.name}' has no bones: add some, or pick another")
    warnings = []
    tree = _one_tree([_read_bone(obj, bone, rotation, warnings) for bone in obj.data.bones], obj.name, warnings)
    bones = tree
    if limit is not None and len(tree) > limit:
        bones = _simplified(tree, limit)
    if len(bones) < 2:
        apart = "" if len(obj.data.bones) == 1 else f" ({len(obj.data.bones)} bones, but not joined: give them parents)"
        raise UserError(f"'{obj.name}' has {len(bones)} bone{apart}: a character needs at least two, joined by a hinge")
    left_out = [b.name for b in tree if b.name not in {kept.name for kept in bones}]
    if left_out:
        warnings.append(f"Simplify keeps {len(bones)} of {len(tree)} bones; left out: {_listed(left_out)}")
    index = {bone.name: i for i, bone in enumerate(bones)}
    return Character(
        obj.name, [b.name for b in bones], [-1 if b.parent is None else index[b.parent] for b in bones],
        [list(b.hinges) for b in bones],
        array("d", (x for b in bones for x in b.head)), array("d", (x for b in bones for x in b.tail)),
        array("d", (x for b in bones for x in b.axes)), array("d", (x for row in rotation for x in row)), warnings, left_out)


def _read_bone(obj, bone, rotation, warnings):
    hinges, explicit = ([], False) if bone.parent is None else hinges_of(obj.pose.bones[bone.name], warnings)
    axes = orthonormal(rotation @ bone.matrix_local.to_3x3())
    return Bone(bone.name, bone.parent.name if bone.parent else None,
                tuple(obj.matrix_world @ bone.head_local), tuple(obj.matrix_world @ bone.tail_local),
                tuple(x for row in axes for x in row), hinges, explicit, bone.use_deform)


def hinges_of(pose_bone, warnings):
    """A bone's hinges by CONTRACT.md, and whether they were set by hand.

    1. Limit Rotation, 2. IK settings, 3. a silent bone: local X, 4. all locked: none.
    """
    ranges = _limit_rotation_ranges(pose_bone, warnings) or _ik_ranges(pose_bone)
    explicit = ranges is not None
    if not explicit:
        ranges = [DEFAULT_RANGE, None, None]
    hinges = []
    for axis, limits in enumerate(ranges):
        if limits is None or limits[1] - limits[0] < NO_RANGE:
            continue
        least, largest = max(limits[0], -math.pi), min(limits[1], math.pi)
        if least > 0 or largest < 0:
            warnings.append(f"bone '{pose_bone.name}': its range about {LETTERS[axis].upper()}, {math.degrees(least):.0f} to "
                            f"{math.degrees(largest):.0f} degrees, leaves out its rest angle 0: it was widened to reach it")
        hinges.append((axis, min(least, 0.0), max(largest, 0.0)))
    return hinges, explicit


def _limit_rotation_ranges(pose_bone, warnings):
    """A range an axis, from all Limit Rotation constraints in local space together; None when none says anything."""
    ranges = [(-math.inf, math.inf)] * 3
    said = False
    for constraint in pose_bone.constraints:
        if constraint.type != "LIMIT_ROTATION" or constraint.mute or constraint.influence <= 0:
            continue
        if constraint.owner_space != "LOCAL":
            warnings.append(f"bone '{pose_bone.name}': its Limit Rotation is not in Local Space, so it was not read: set its Owner to "
                            "Local Space")
            continue
        for axis, letter in enumerate(LETTERS):
            if not getattr(constraint, f"use_limit_{letter}"):
                continue
            said = True
            least, largest = getattr(constraint, f"min_{letter}"), getattr(constraint, f"max_{letter}")
            if least > largest:
                raise UserError(f"bone '{pose_bone.name}': Limit Rotation about {letter.upper()} has its minimum above its "
                                "maximum: swap them")
            ranges[axis] = (max(ranges[axis][0], least), min(ranges[axis][1], largest))
    if not said:
        return None
    # An axis that no constraint limits is as free as one without an IK limit.
    return [DEFAULT_RANGE if math.isinf(r[1]) else r for r in ranges]


def _ik_ranges(pose_bone):
    """A range an axis, None for a locked one; None when the bone says nothing."""
    locked = [getattr(pose_bone, f"lock_ik_{letter}") for letter in LETTERS]
    limited = [getattr(pose_bone, f"use_ik_limit_{letter}") for letter in LETTERS]
    if not any(locked) and not any(limited):
        return None
    ranges = []
    for letter, is_locked, is_limited in zip(LETTERS, locked, limited):
        limits = (getattr(pose_bone, f"ik_min_{letter}"), getattr(pose_bone, f"ik_max_{letter}"))
        ranges.append(None if is_locked else limits if is_limited else DEFAULT_RANGE)
    return ranges


def _rotation_of(obj):
    """The object's rotation in the world. @raises UserError when its scale isn't one positive number"""
    matrix = obj.matrix_world.to_3x3()
    lengths = [matrix.col[i].length for i in range(3)]
    if not all(math.isfinite(x) for row in matrix for x in row) or min(lengths) <= 0:
        raise UserError(f"the armature '{obj.name}' has a scale of zero or one that is no number: clear its scale (Alt+S)")
    skew = max(abs(matrix.col[i].normalized().dot(matrix.col[j].normalized())) for i, j in ((0, 1), (0, 2), (1, 2)))
    if max(lengths) > (1 + 1e-4) * min(lengths) or skew > 1e-4:
        raise UserError(f"the armature '{obj.name}' is scaled unevenly: apply its scale (Ctrl+A, Scale)")
    if matrix.determinant() < 0:
        raise UserError(f"the armature '{obj.name}' has a negative scale: apply its scale (Ctrl+A, Scale)")
    return Matrix(orthonormal(matrix))


def orthonormal(matrix):
    """The rotation of a matrix in double precision (Blender's own are single): Gram-Schmidt, Y first as bones run along it."""
    y = _unit([matrix[r][1] for r in range(3)])
    x = [matrix[r][0] for r in range(3)]
    along = sum(a * b for a, b in zip(x, y))
    x = _unit([a - along * b for a, b in zip(x, y)])
    z = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
    return tuple(zip(x, y, z))


def _unit(v):
    length = math.sqrt(sum(a * a for a in v))
    return [a / length for a in v]


def _one_tree(bones, name, warnings):
    """The bones of one root, parents first; of several roots, the tree that Simplify calls the character's."""
    mappings = _mappings(bones)
    dropped = set(_asked(simplify.dropped_roots, mappings))
    root = next(b.name for b in bones if b.parent is None and b.name not in dropped)
    children = {}
    for bone in bones:
        children.setdefault(bone.parent, []).append(bone)
    tree = [b for b in bones if b.name == root]
    for bone in tree:
        tree.extend(children.get(bone.name, ()))
    if dropped:
        inside = {b.name for b in tree}
        warnings.append(f"'{name}' has {len(dropped) + 1} roots: the tree of '{root}' with {len(tree)} bones is the character; "
                        f"left out: {_listed([b.name for b in bones if b.name not in inside])}")
    return tree


def _simplified(bones, limit):
    """The bones that Simplify proposes to keep. Each keeps its own axes and hinges; its link may span dropped ones."""
    mappings = _mappings(bones)
    kept = _asked(simplify.propose, mappings, limit)
    by_name = {b.name: b for b in bones}
    return [replace(by_name[s.name], parent=s.parent, tail=tuple(s.tail)) for s in _asked(simplify.simplified, mappings, kept)]


def _mappings(bones):
    return [{"name": b.name, "parent": b.parent, "head": b.head, "tail": b.tail, "explicit": b.explicit, "deform": b.deform}
            for b in bones]


def _asked(function, *arguments):
    try:
        return function(*arguments)
    except ValueError as error:
        raise UserError(str(error)) from None


def _listed(names, most=12):
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
