# SPDX-License-Identifier: GPL-3.0-or-later
"""Folded poses of a character in a target: taken from what is stored, and told to those who draw them and choose between them."""
from array import array

from . import kinematics, outcome
from .options import LONGEST_SIDE, UserError

TOUCHING_BONES = 1e-4       # target units: capsules that are less deep in one another do not collide


class Poses:
    """Of a native `character` whose bones have rest `heads`, `tails` and `axes` (raw float64), in a `target` of some resolution."""

    def __init__(self, native, character, target, resolution, heads, tails, axes):
        self.tn, self.character, self.target, self.resolution = native, character, target, resolution
        self.skeleton = kinematics.Skeleton(character.members, character.parents, character.hinges, character.first_angle,
                                            *(array("d", bytes(raw)) for raw in (heads, tails, axes)))

    def native(self, stored):
        """A pose as an earlier result gave it. Raises UserError when it is another character's."""
        root, angles, morphology = stored["root"], stored["angles"], stored["morphology"]
        if len(angles) != self.character.angle_count or len(morphology) != len(self.character.names):
            raise UserError("the stored folded pose is for another character: run the embedding stage again")
        return self.tn.Embedding(root=list(root), angles=list(angles), morphology=list(morphology),
                                 symmetric=bool(stored.get("symmetric", False)))

    def solution(self, embedding):
        """One embedding with what the artist wants to know of it: lines to draw it, and which bones are not as they should be."""
        names = self.character.names
        fit = self.tn.skeleton_fit(self.character, self.target, embedding)
        least = LONGEST_SIDE / self.resolution
        return {**outcome.embedding(embedding), "points": self._points(embedding),
                "outside": [names[i] for i, depth in enumerate(fit["protrusion"]) if depth > least],
                "colliding": [[names[i], names[j]] for i, j, depth in fit["collisions"] if depth > TOUCHING_BONES]}

    def shown(self, embedding):
        """One embedding as it is shown while the search goes on."""
        return {"root": list(embedding.root), "angles": list(embedding.angles), "morphology": list(embedding.morphology),
                "terms": dict(embedding.terms), "value": embedding.value, "points": self._points(embedding)}

    def _points(self, embedding):
        """A pose as lines between points in Blender's world (two a bone)."""
        scale, centre = self.target.scale, self.target.centre
        root = embedding.root
        rotation = tuple(tuple(root[4 * c + r] for c in range(3)) for r in range(3))
        head = tuple(root[12 + r] / scale + centre[r] for r in range(3))
        lengths = self.character.scale / scale
        frames = self.skeleton.frames(rotation, head, embedding.angles, embedding.morphology, lengths)
        ends = self.skeleton.bone_ends(frames, embedding.morphology, lengths)
        return [p for _, a, b in ends for p in (a, b)]
