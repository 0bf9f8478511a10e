# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a pose puts the bones: forward kinematics in plain Python, for previews, the result's rig and its tests.

Frames as in native/character/character.h: a body's frame has its origin at the head of the armature bone that leads
it, and that bone's axes. Matrices are tuples of three rows.
"""
import math


def matrix_of(values):
    """Three rows of nine numbers, row by row."""
    return tuple(tuple(values[3 * r:3 * r + 3]) for r in range(3))


def multiply(a, b):
    return tuple(tuple(sum(a[r][k] * b[k][c] for k in range(3)) for c in range(3)) for r in range(3))


def transposed(m):
    return tuple(zip(*m))


def turned(m, v):
    return tuple(sum(m[r][k] * v[k] for k in range(3)) for r in range(3))


def joint_rotation(hinges, angles):
    """X, then Y, then Z about the same point, as Blender's XYZ Euler angles: Rz Ry Rx."""
    result = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    for (axis, _, _), angle in zip(hinges, angles):
        c, s = math.cos(angle), math.sin(angle)
        turn = (((1, 0, 0), (0, c, -s), (0, s, c)),
                ((c, 0, s), (0, 1, 0), (-s, 0, c)),
                ((c, -s, 0), (s, c, 0), (0, 0, 1)))[axis]
        result = multiply(turn, result)
    return result


class Skeleton:
    """The rigid bodies of a character, with where their bones are at rest (character frame, Blender units)."""

    def __init__(self, members, parents, hinges, first_angle, heads, tails, axes):
        """`heads`, `tails`, `axes`: a triple, a triple and nine numbers an armature bone, in sequence."""
        self.members, self.parents, self.hinges, self.first_angle = members, parents, hinges, first_angle
        self.heads = [tuple(heads[3 * i:3 * i + 3]) for i in range(len(heads) // 3)]
        self.tails = [tuple(tails[3 * i:3 * i + 3]) for i in range(len(tails) // 3)]
        self.axes = [matrix_of(axes[9 * i:9 * i + 9]) for i in range(len(axes) // 9)]

    def frames(self, root_rotation, root_head, angles, morphology, scale):
        """(rotation, head) of each body; lengths within body i are multiplied by scale * morphology[i]."""
        frames = []
        for body, parent in enumerate(self.parents):
            if parent < 0:
                frames.append((root_rotation, tuple(root_head)))
                continue
            rotation, head = frames[parent]
            lead, parent_lead = self.members[body][0], self.members[parent][0]
            to_parent = transposed(self.axes[parent_lead])
            offset = turned(to_parent, _difference(self.heads[lead], self.heads[parent_lead]))
            rest = multiply(to_parent, self.axes[lead])
            first = self.first_angle[body]
            joint = joint_rotation(self.hinges[body], angles[first:first + len(self.hinges[body])])
            frames.append((multiply(multiply(rotation, rest), joint),
                           _moved(head, turned(rotation, offset), scale * morphology[parent])))
        return frames

    def bone_ends(self, frames, morphology, scale):
        """Head and tail of every armature bone that has a body, body by body: [(bone, head, tail), ...]."""
        ends = []
        for (rotation, head), members, factor in zip(frames, self.members, morphology):
            lead = members[0]
            to_lead = transposed(self.axes[lead])
            for bone in members:
                points = [turned(to_lead, _difference(p, self.heads[lead])) for p in (self.heads[bone], self.tails[bone])]
                ends.append((bone, *(_moved(head, turned(rotation, p), scale * factor) for p in points)))
        return ends


def _difference(a, b):
    return tuple(x - y for x, y in zip(a, b))


def _moved(point, direction, factor):
    return tuple(x + factor * d for x, d in zip(point, direction))
