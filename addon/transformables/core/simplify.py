# SPDX-License-Identifier: GPL-3.0-or-later
"""Fewer bones: which of a rig's bones matter for a transformable, and the skeleton that they make.

A rig made for animation has many bones that no printed toy needs: faces, fingers, helpers. `propose` takes bones
away, the one whose loss matters least first, until few enough are left and each of them is worth its joint.
Geometry decides (how long a bone's link is, how much hangs on it, how many small siblings it has); names only
weigh, because every rig names its bones in its own way. A bone and its mirror image always go together.

A bone is a mapping with `name`, `parent` (a name or None), `head`, `tail` (three numbers each); optional are
`explicit` (its hinges were set by hand: preferred to be kept) and `deform` (False for controls).
"""
from __future__ import annotations

import math
from dataclasses import dataclass

from .bone_names import weight_of_name
from .bone_tree import Skeleton, mirror_images, relinked
from .options import UserError

FEWEST = 15             # a proposal stops here, unless fewer are asked for
WORTH = 0.02            # a bone that costs less than this share of the character's size is not worth a joint
EXPLICIT_WEIGHT = 10.0
LEAST_LINK = 0.01       # a joint set by hand counts as if its link had this share of the size: several may share a point
CONTROL_WEIGHT = 0.1    # of a bone that deforms nothing, where others do
BUNCH_WEIGHT = 0.3      # of one of several small siblings, as fingers are
BUNCH_REACH = 0.12      # how far a small sibling reaches at most, of the character's size
BRANCH_WEIGHT = 3.0     # a bone that carries several others
START_WEIGHT = 1.0      # the first joint of a limb, of the mean of the links that meet in it
CHAIN_WEIGHT = 0.5      # a joint inside a chain, of the mean of its two links
STUB_WEIGHT = 0.5       # a bone on which nothing hangs, and that no chain leads to
MIDDLE_WEIGHT = 0.3     # the same in a spine, neck or tail of many pieces
MIDDLE_PIECES = 3       # that such a chain keeps without discount


@dataclass(frozen=True)
class SimpleBone:
    """A bone of the simplified skeleton; `merged` names the bones that its link now spans, from head to tail."""

    name: str
    parent: str | None
    head: tuple[float, float, float]
    tail: tuple[float, float, float]
    merged: tuple[str, ...] = ()


def _harmonic_mean(a, b):
    return 2 * a * b / (a + b) if a + b > 0 else 0.0


class _Costs:
    """What it would cost to lose a bone, in shares of the character's size."""

    def __init__(self, skeleton, image):
        self.skeleton = skeleton
        self.image = image
        self.nearest = {}   # kept ancestor of each bone of the kept tree that `costs` looked at last
        subtrees = {name: skeleton.subtree(name) for name in skeleton.tree}
        self.reach = {name: max(math.dist(skeleton.head(name), skeleton.tail(n)) for n in tree)
                      for name, tree in subtrees.items()}
        self.weight = self._weights()
        lengths = {name: skeleton.length(name) for name in skeleton.tree}
        total = sum(lengths.values())
        self.mostly_middle = sum(lengths[n] for n in skeleton.tree if image[n] == n) > 0.5 * total

    def _weights(self):
        """By name, by hand-set hinges, by siblings; what hangs on a face or a helper is weighed like it."""
        skeleton = self.skeleton
        deforms = any(skeleton.bones[n].get("deform", True) for n in skeleton.tree)
        weights, inherited = {}, {}
        for name in skeleton.tree:
            bone, parent = skeleton.bones[name], skeleton.parent(name)
            own, below = weight_of_name(name, leaf=not skeleton.children[name])
            inherited[name] = min(below, inherited.get(parent, 1.0))
            weight = min(own, inherited[name])
            if deforms and not bone.get("deform", True):
                weight = min(weight, CONTROL_WEIGHT)
            if self._in_bunch(name) and weight > BUNCH_WEIGHT:
                weight = BUNCH_WEIGHT
                inherited[name] = min(inherited[name], BUNCH_WEIGHT)
            # A joint that somebody set by hand is wanted, whatever it is called.
            weights[name] = EXPLICIT_WEIGHT if bone.get("explicit") else weight
        return weights

    def _in_bunch(self, name):
        skeleton = self.skeleton
        parent = skeleton.parent(name)
        if parent is None or self.reach[name] > BUNCH_REACH * skeleton.size:
            return False
        small = [n for n in skeleton.children[parent] if self.reach[n] <= BUNCH_REACH * skeleton.size]
        # Pairs on both sides of the middle are not a bunch; three on one limb are.
        return len({min(n, self.image[n]) for n in small}) >= 3

    def link(self, name, kept_children):
        """How long a bone's link is while these are its children."""
        if not kept_children:
            return self.reach[name]
        head = self.skeleton.head(name)
        return max(self.skeleton.length(name), *(math.dist(head, self.skeleton.head(child)) for child in kept_children))

    def cost(self, name, children, parent):
        """For the kept tree `children`, in which `parent` is the bone's nearest kept ancestor."""
        kept, own = children[name], self.link(name, children[name])
        # Losing the joint welds two links; the shorter counts most for the motion that goes.
        welded = _harmonic_mean(own, self.link(parent, children[parent]))
        starts_limb = len(children[parent]) > 1
        if kept:
            value = welded * (BRANCH_WEIGHT if len(kept) > 1 else START_WEIGHT if starts_limb else CHAIN_WEIGHT)
        elif starts_limb:
            value = own * STUB_WEIGHT
        else:
            value = welded * CHAIN_WEIGHT if self.image[name] == name else own
        if self.image[name] == name and not self.mostly_middle and self._pieces(name, children, parent) > MIDDLE_PIECES:
            value *= MIDDLE_WEIGHT
        if self.skeleton.bones[name].get("explicit"):
            value = max(value, LEAST_LINK * self.skeleton.size)
        return value * self.weight[name] / self.skeleton.size

    def _pieces(self, name, children, parent):
        """Of how many bones the chain in the middle is that this bone is in, with those where it branches."""
        count, below, above = 1, children[name], parent
        while len(below) == 1 and self.image[below[0]] == below[0]:
            count, below = count + 1, children[below[0]]
        while above is not None and len(children[above]) == 1:
            count, above = count + 1, self.nearest[above]
        return count + (above is not None)

    def costs(self, kept):
        """The cost of every kept bone but the root."""
        self.nearest, children = relinked(self.skeleton, kept)
        return {n: self.cost(n, children, self.nearest[n]) for n in children if self.nearest[n] is not None}


def propose(bones, limit=25):
    """Names of the bones to keep, at most `limit` of them, in the armature's order.

    A tree that has no more bones is returned whole. Of several roots, the tree with the most deforming length
    counts (`dropped_roots` names the others).
    Raises UserError for a limit under 2, no bones, names used twice, missing parents, cycles or positions that are
    not finite.
    """
    if limit < 2:
        raise UserError(f"at least 2 bones must be kept, not {limit}")
    skeleton = Skeleton(bones)
    kept = set(skeleton.tree)
    if len(kept) > limit:
        image = mirror_images(skeleton)
        costs = _Costs(skeleton, image)
        # Two bones are one joint: no pair can stay, so pairs may be parted.
        together = image if limit > 2 else {name: name for name in image}
        while len(kept) > min(limit, FEWEST):
            value, names = _cheapest(costs.costs(kept), together, len(kept) - 2)
            enough = len(kept) <= limit
            if enough and (len(kept) - len(names) < FEWEST or value >= WORTH):
                break
            kept.difference_update(names)
    return [name for name in skeleton.names if name in kept]


def _cheapest(costs, image, most):
    """The bone, or mirror pair, whose loss matters least; ties go by name, so that the result is the same everywhere.

    No more than `most` bones: a pair that is too many is passed over.
    """
    units = {}
    for name, cost in costs.items():
        key = tuple(sorted({name, image[name]}))
        units[key] = max(cost, units.get(key, 0.0))
    return min((round(cost, 12), names) for names, cost in units.items() if len(names) <= most)


def dropped_roots(bones):
    """Roots of the trees that `propose` leaves out, in the armature's order."""
    return Skeleton(bones).dropped_roots


def simplified(bones, kept):
    """The skeleton of the bones named in `kept`: a list of SimpleBone, parents before children.

    Each bone's parent is its nearest kept ancestor. A bone from which a chain of dropped bones went on, end to end,
    gets the tail of that chain, so that its link still spans it.
    Raises UserError when a name is unknown, or when the bones do not hang together in one tree.
    """
    skeleton = Skeleton(bones)
    kept = set(kept)
    unknown = sorted(kept - set(skeleton.tree))
    if unknown:
        raise UserError(f"bone '{unknown[0]}' is not in the character's tree")
    if not kept:
        raise UserError("no bone is kept: keep at least two")
    nearest, children = relinked(skeleton, kept)
    tops = [name for name in children if nearest[name] is None]
    if len(tops) > 1:
        raise UserError(f"'{tops[0]}' and '{tops[1]}' have no kept bone in common above them: keep '{skeleton.root}' too")
    carrying = _carrying(skeleton, kept)
    result = []
    for name in children:
        merged = _spanned(skeleton, name, kept, carrying)
        tail = skeleton.tail(merged[-1] if merged else name)
        result.append(SimpleBone(name, nearest[name], tuple(skeleton.head(name)), tuple(tail), tuple(merged)))
    return result


def _carrying(skeleton, kept):
    """Bones below which some bone is kept."""
    carrying = set()
    for name in reversed(skeleton.tree):
        if name in kept or name in carrying:
            carrying.add(skeleton.parent(name))
    return carrying


def _spanned(skeleton, name, kept, carrying):
    """The dropped bones that go on from this one, end to end and without turning back."""
    chain, last = [], name
    while True:
        end = skeleton.tail(last)
        following = [n for n in skeleton.children[last] if math.dist(skeleton.head(n), end) <= 1e-4 * skeleton.size]
        if not following or any(n in kept for n in following):
            return chain
        best = max(following, key=lambda n: (n in carrying, skeleton.length(n), n))
        onward = [b - a for a, b in zip(skeleton.head(name), end)]
        step = [b - a for a, b in zip(skeleton.head(best), skeleton.tail(best))]
        lengths = math.hypot(*onward) * math.hypot(*step)
        if lengths == 0 or sum(a * b for a, b in zip(onward, step)) < 0.5 * lengths:
            return chain
        chain.append(best)
        last = best
