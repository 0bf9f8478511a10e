# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves that follow each other, made one where it is proved that their joints can turn at the same time.

A move is a list of turns (angle index, from, to); an interval is (move, bone, bone, from, to, bound), as core/certificate.py has it.
"""
from dataclasses import dataclass

PROVED_AGAIN = 0.999       # of the gap that is proved, that joints which turn together must keep: proofs differ by rounding
TOLERANCE = 0.02           # of their gap, by which a proof of that may fall short of the truth
STEPS = 1_000_000          # comparisons of a pair, after which such a proof is given up: the moves stay one after the other


@dataclass
class _Group:
    start: list        # all angles before it
    turns: list
    old: list          # the moves it is made of
    rows: list         # its proof


def joined_where_proved(native, parts, character, embedding, moves, threads, progress):
    """As `joined`, by proofs of native parts, whose certificate of these moves holds: for as much of a gap as that has."""
    certificate, tried = parts.certificate, []

    def prove(angles, turns, pairs):
        tried.append(turns)
        pose = native.Embedding(root=list(embedding.root), angles=list(angles), morphology=list(embedding.morphology), symmetric=False)
        proof = native.certify(parts, character, pose, native.FoldPath(moves=[turns]), least=certificate.gap * PROVED_AGAIN,
                               enough=certificate.gap, tolerance=TOLERANCE, steps=STEPS, pairs=pairs, to_the_end=False, threads=threads,
                               progress=lambda *_: progress(min(1.0, len(tried) / len(moves)), "joints that can turn together"))
        return proof.intervals if proof.holds and proof.gap >= certificate.gap * PROVED_AGAIN else None

    return joined(moves, certificate.intervals, list(embedding.angles), lambda turns: pairs_moved(character, turns), prove)


def joined(moves, intervals, folded_angles, pairs_moved, prove):
    """Gives (moves, intervals, new_of): `new_of[n]` is the move that move n has become a part of.

    `intervals` prove the moves as they are. `pairs_moved(turns)` is the set of pairs of bones (lesser first) that move against each other.
    `prove(angles, turns, pairs)` gives the intervals of these pairs in one move from these angles, or None when there is no proof: then the
    move stays apart. Each move is tried with those before it, in order, so that the fold's order stays. Only pairs that both move need a proof:
    others do in the joined move just what they did in their own.
    """
    groups, now = [], list(folded_angles)
    for number, turns in enumerate(moves):
        rows = [row for row in intervals if row[0] == number]
        if not _joins(groups, number, turns, rows, pairs_moved, prove):
            groups.append(_Group(list(now), list(turns), [number], rows))
        for angle, _, end in turns:
            now[angle] = end
    new_of = {old: new for new, group in enumerate(groups) for old in group.old}
    rows = [(new, *row[1:]) for new, group in enumerate(groups) for row in group.rows]
    return [group.turns for group in groups], rows, [new_of[number] for number in range(len(moves))]


def _joins(groups, number, turns, rows, pairs_moved, prove):
    """Makes a move part of the last group where that is proved."""
    if not groups or {angle for angle, _, _ in groups[-1].turns} & {angle for angle, _, _ in turns}:
        return False
    group = groups[-1]
    by_group, by_move = pairs_moved(group.turns), pairs_moved(turns)
    both = by_group & by_move
    proof = prove(group.start, [*group.turns, *turns], sorted(both)) if both else []
    if proof is None:
        return False
    kept = [row for row in group.rows if _pair(row) not in by_move] + [row for row in rows if _pair(row) in by_move - by_group]
    group.rows = sorted([*kept, *proof], key=lambda row: row[1:])
    group.turns = [*group.turns, *turns]
    group.old.append(number)
    return True


def _pair(row):
    return row[1], row[2]


def pairs_moved(character, turns):
    """Bodies that move against each other, when some hinges turn, in pairs (lesser first): those with such a joint between them."""
    turned = {angle for angle, _, _ in turns}
    above = []  # for each body the turning joints between it and the root
    for body, parent in enumerate(character.parents):
        first = character.first_angle[body]
        own = any(first + k in turned for k in range(len(character.hinges[body])))
        above.append((above[parent] if parent >= 0 else frozenset()) | ({body} if own else frozenset()))
    return {(a, b) for b in range(len(above)) for a in range(b) if above[a] != above[b]}
