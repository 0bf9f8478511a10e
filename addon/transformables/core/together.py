# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves that follow each other, made one where it is proved that their joints can turn at the same time.

A move is a list of turns (angle index, from, to); an interval is (move, bone, bone, from, to, bound), as core/certificate.py has it.
"""
from dataclasses import dataclass


@dataclass
class _Group:
    start: list        # all angles before it
    turns: list
    old: list          # the moves it is made of
    rows: list = None  # its proof, once it is made of several


def joined(moves, intervals, folded_angles, prove):
    """Gives (moves, intervals, new_of): `new_of[n]` is the move that move n has become a part of.

    `intervals` prove the moves as they are. `prove(angles, turns)` gives the intervals of one move from these angles, or None when there is
    no proof: then the move stays apart. Each move is tried with those before it, in order, so that the fold's order stays.
    """
    groups, now = [], list(folded_angles)
    for number, turns in enumerate(moves):
        if not _joins(groups, number, turns, prove):
            groups.append(_Group(list(now), list(turns), [number]))
        for angle, _, end in turns:
            now[angle] = end
    new_of = {old: new for new, group in enumerate(groups) for old in group.old}
    rows = []
    for new, group in enumerate(groups):
        found = group.rows if group.rows is not None else [row for row in intervals if row[0] == group.old[0]]
        rows += [(new, *row[1:]) for row in found]
    return [group.turns for group in groups], rows, [new_of[number] for number in range(len(moves))]


def _joins(groups, number, turns, prove):
    """Makes a move part of the last group where that is proved."""
    if not groups or {angle for angle, _, _ in groups[-1].turns} & {angle for angle, _, _ in turns}:
        return False
    group = groups[-1]
    rows = prove(group.start, [*group.turns, *turns])
    if rows is None:
        return False
    group.turns, group.rows = [*group.turns, *turns], rows
    group.old.append(number)
    return True
