# SPDX-License-Identifier: GPL-3.0-or-later
"""An armature's bones as a tree: checked, with each bone's mirror image, and relinked over those that are kept."""
from __future__ import annotations

import math

from .bone_names import name_of_other_side
from .options import UserError

MIRROR_TOLERANCE = 0.01  # of the character's size


class Skeleton:
    """The largest tree of an armature, with what is asked of it often."""

    def __init__(self, bones):
        self.names = [bone["name"] for bone in bones]
        self.bones = {bone["name"]: bone for bone in bones}
        _check(bones, self.bones)
        self.children = {name: [] for name in self.names}
        for bone in bones:
            if bone["parent"] is not None:
                self.children[bone["parent"]].append(bone["name"])
        roots = [bone["name"] for bone in bones if bone["parent"] is None]
        trees = [self._tree(root) for root in roots]
        if sum(map(len, trees)) != len(bones):
            raise UserError("the armature's parents form a cycle: mend the hierarchy")
        best = max(range(len(roots)), key=lambda i: (self._deforming_length(trees[i]), len(trees[i]), -i))
        self.root = roots[best]
        self.dropped_roots = [root for root in roots if root != self.root]
        self.tree = trees[best]     # parents before children
        corners = [self.bones[n][end] for n in self.tree for end in ("head", "tail")]
        self.size = math.dist([min(c[i] for c in corners) for i in range(3)], [max(c[i] for c in corners) for i in range(3)])
        if not self.size > 0:
            raise UserError("all bones of the armature are at one point: give them lengths")

    def head(self, name):
        return self.bones[name]["head"]

    def tail(self, name):
        return self.bones[name]["tail"]

    def parent(self, name):
        return self.bones[name]["parent"]

    def length(self, name):
        return math.dist(self.head(name), self.tail(name))

    def _tree(self, root):
        order, pending = [], [root]
        while pending:
            name = pending.pop()
            order.append(name)
            pending.extend(reversed(self.children[name]))
        return order

    def _deforming_length(self, tree):
        return sum(self.length(name) for name in tree if self.bones[name].get("deform", True))

    def subtree(self, name):
        return self._tree(name)


def _check(bones, by_name):
    if not bones:
        raise UserError("the armature has no bones")
    if len(by_name) != len(bones):
        raise UserError("two bones of the armature have the same name: rename one")
    for bone in bones:
        if bone["parent"] is not None and bone["parent"] not in by_name:
            raise UserError(f"bone '{bone['name']}': its parent '{bone['parent']}' does not exist")
        if not all(math.isfinite(x) for end in ("head", "tail") for x in bone[end]):
            raise UserError(f"bone '{bone['name']}': its position is not a finite number; move or delete the bone")


def mirror_images(skeleton):
    """The bone on the other side, for each bone: by name, else by geometry; itself when there is none."""
    plane = skeleton.head(skeleton.root)[0]
    tolerance = MIRROR_TOLERANCE * skeleton.size
    known = set(skeleton.tree)
    image = {}
    for name in skeleton.tree:
        other = name_of_other_side(name)
        if other != name and other in known and name_of_other_side(other) == name:
            image[name] = other

    def reflected(point):
        return (2 * plane - point[0], point[1], point[2])

    for name in skeleton.tree:
        if name in image:
            continue
        head, tail = reflected(skeleton.head(name)), reflected(skeleton.tail(name))
        parent = skeleton.parent(name)
        wanted = None if parent is None else image.get(parent, parent)
        image[name] = name
        if math.dist(head, skeleton.head(name)) <= tolerance and math.dist(tail, skeleton.tail(name)) <= tolerance:
            continue
        for other in skeleton.children.get(wanted, ()):
            fits = math.dist(head, skeleton.head(other)) <= tolerance and math.dist(tail, skeleton.tail(other)) <= tolerance
            if fits and other != name and image.get(other, other) == other:
                image[name], image[other] = other, name
                break
    return image


def relinked(skeleton, kept):
    """The nearest kept ancestor of each kept bone (None: it has none), and its kept children."""
    above, nearest = {}, {}
    children = {name: [] for name in skeleton.tree if name in kept}
    for name in skeleton.tree:
        parent = skeleton.parent(name)
        ancestor = None if parent is None else (parent if parent in kept else above[parent])
        above[name] = ancestor
        if name in kept:
            nearest[name] = ancestor
            if ancestor is not None:
                children[ancestor].append(name)
    return nearest, children
