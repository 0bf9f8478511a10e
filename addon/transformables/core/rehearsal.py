# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of a folded pose: each is divided and unfolded on trial, and the one that loses least to carving is taken."""
from typing import NamedTuple

from . import blocks
from .options import LONGEST_SIDE

GOOD_ENOUGH_PCT = 1.0      # of the target, carved: the next pose is not tried then
HOPELESS = 1.5             # times what the best loses: a pose that lost more when it was rehearsed roughly is not tried
POOR_PCT = 4.0             # when the best of the poses roughly loses more, the search is done once more, elsewhere
APART = 10.0               # how much more the pairs' share counts that are to be kept apart
ROUGHLY = {"rounds": 1, "expansions": 200, "round_off": False}   # how well the unfolding of each is searched, to tell them apart
ROUGH_RESOLUTION = 40      # voxels along the longest side, for that: enough to rank poses as the design's own grid does
SAME_TARGET = {"place": 1e-3, "volume": 0.1}   # target units, share: by which a coarser target may differ


class Rehearsal(NamedTuple):
    """A folded pose, how it divides the target, how that unfolds, and what carving would take, as a share of the target; what it
    would take from pairs that are to be kept apart counts more."""
    embedding: object
    segmentation: object
    folding: object
    loss_pct: float


def _part(progress, start, end):
    return lambda fraction, note="": progress(start + (end - start) * fraction, note)


class Rehearsals:
    """`apart` are pairs of bodies that are to be kept apart; grow(embedding, target, progress, round_off), fold(embedding, target, segmentation, progress, **search)
    and make_target(resolution, progress) do the work as core/pipeline.py does it."""

    def __init__(self, native, target, options, apart, grow, fold, make_target):
        self.tn, self.target, self.options, self.apart = native, target, options, apart
        self.grow, self.fold, self.make_target = grow, fold, make_target

    def best(self, found, more, rival, progress):
        """The Rehearsal that loses least: of the two best of those found, or the first when it loses little or the second has no hope, and of a rival, should there be one.
        When all those found lose much, `more(progress)` gives others to choose from.

        Skeletons that stick out of the target, or through themselves, are the last resort, and poses that leave painted regions to other bones
        are not asked for what they lose.
        """
        tries = [*self._two_best(found, more, _part(progress, 0.0, 1 / 3)), *([(rival, None)] if rival else [])]
        best = None
        for k, (embedding, roughly_pct) in enumerate(tries):
            if best and roughly_pct is not None and roughly_pct > HOPELESS * best.loss_pct:
                continue
            rehearsal = self._rehearsal(embedding, self.target, _part(progress, (1 + 2 * k / len(tries)) / 3, (1 + 2 * (k + 1) / len(tries)) / 3))
            if best is None or rehearsal.loss_pct < best.loss_pct:
                best = rehearsal
            if rehearsal.loss_pct < GOOD_ENOUGH_PCT and not rival:
                break
        return best

    def _worth_trying(self, found):
        sound = [embedding for embedding in found if self._sound(embedding)] or found[:1]
        closest = min(embedding.missed for embedding in sound) + LONGEST_SIDE / self.options.resolution
        return [embedding for embedding in sound if embedding.missed <= closest]

    def _two_best(self, found, more, progress):
        """Of several poses the two that lose least when they are rehearsed roughly, on a coarse grid; and how much they lose then, in %."""
        worth = self._worth_trying(found)
        if len(worth) < 2:
            return [(embedding, None) for embedding in worth]
        target = self._coarse_target(progress)
        rough = self._roughly(worth, target, _part(progress, 0.0, 0.3))
        if rough[0].loss_pct > POOR_PCT:
            everything = self._worth_trying([*found, *more(_part(progress, 0.3, 0.7))])
            known = [rehearsal for rehearsal in rough if rehearsal.embedding in everything]
            new = [embedding for embedding in everything if embedding not in found]
            rough = sorted([*known, *self._roughly(new, target, _part(progress, 0.7, 1.0))], key=lambda rehearsal: rehearsal.loss_pct)
        return [(rehearsal.embedding, rehearsal.loss_pct) for rehearsal in rough[:2]]

    def _roughly(self, embeddings, target, progress):
        rough = [self._rough_rehearsal(embedding, target, _part(progress, k / len(embeddings), (k + 1) / len(embeddings)))
                 for k, embedding in enumerate(embeddings)]
        return sorted(rough, key=lambda rehearsal: rehearsal.loss_pct)

    def _coarse_target(self, progress):
        """The target on a coarse grid; the target itself where it is coarse already, or too much of it would be lost."""
        if self.options.resolution <= ROUGH_RESOLUTION:
            return self.target
        try:
            coarse = self.make_target(ROUGH_RESOLUTION, _part(progress, 0.0, 0.0))
        except self.tn.InvalidInput:  # too thin for that
            return self.target
        places = [abs(a - b) * self.target.scale for a, b in zip(coarse.centre, self.target.centre)] + [abs(coarse.scale / self.target.scale - 1)]
        alike = max(places) < SAME_TARGET["place"] and abs(coarse.volume / self.target.volume - 1) < SAME_TARGET["volume"]
        return coarse if alike else self.target

    def _rough_rehearsal(self, embedding, target, progress):
        try:
            return self._rehearsal(embedding, target, progress, **ROUGHLY)
        except self.tn.Infeasible:
            if target is self.target:
                raise
            return self._rehearsal(embedding, self.target, progress, **ROUGHLY)  # there is room for every bone on the fine grid only

    def _rehearsal(self, embedding, target, progress, round_off=True, **search):
        segmentation = self.grow(embedding, target, _part(progress, 0.0, 0.3), round_off)
        folding = self.fold(embedding, target, segmentation, _part(progress, 0.3, 1.0), round_off=round_off, **search)
        loss = folding.carving_after / target.volume
        if self.apart:
            path = {"collisions": folding.path.collisions}
            loss += APART * sum(blocks.share_of(path, pair, target.volume) for pair in self.apart)
        return Rehearsal(embedding, segmentation, folding, 100 * loss)

    def _sound(self, embedding):
        least = LONGEST_SIDE / self.options.resolution
        return embedding.deepest_protrusion < least and embedding.deepest_collision < least
