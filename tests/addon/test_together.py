# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves made one where it is proved that their joints can turn at the same time."""
import os
import struct
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import IDENTITY, job_of, played, two_bones
from transformables.core.schedule import check_path
from transformables.core.together import joined

MOVES = [[(0, 1.0, 0.0)], [(1, 0.5, 0.7), (2, 0.5, 0.0)], [(1, 0.7, 0.0)], [(3, -0.2, 0.0)]]
FOLDED = [1.0, 0.5, 0.5, -0.2]
ROWS = [(m, 0, 1, 0.0, 1.0, 0.1 * (m + 1)) for m in range(4)]


ALL = {(0, 1)}


def proved(angles, turns, pairs):
    return [(0, 0, 1, 0.0, 0.5, 9.0), (0, 0, 1, 0.5, 1.0, 9.0)]


def test_moves_are_joined_while_it_is_proved_and_no_joint_turns_twice():
    asked = []

    def prove(angles, turns, pairs):
        asked.append((angles, turns, pairs))
        return proved(angles, turns, pairs)

    moves, rows, new_of = joined(MOVES, ROWS, FOLDED, lambda turns: ALL, prove)
    assert moves == [MOVES[0] + MOVES[1], MOVES[2] + MOVES[3]] and new_of == [0, 0, 1, 1]
    check_path(moves, FOLDED)
    assert [row[0] for row in rows] == [0, 0, 1, 1]
    assert asked == [(FOLDED, MOVES[0] + MOVES[1], [(0, 1)]), ([0.0, 0.7, 0.0, -0.2], MOVES[2] + MOVES[3], [(0, 1)])], "each from where the joints stand by then"


def test_without_a_proof_every_move_stays_and_keeps_its_own_intervals():
    assert joined(MOVES, ROWS, FOLDED, lambda turns: ALL, lambda *_: None) == (MOVES, ROWS, [0, 1, 2, 3])


def test_a_move_that_cannot_join_starts_the_next_group_and_intervals_follow_their_moves():
    def prove(angles, turns, pairs):
        return None if (0, 1.0, 0.0) in turns else proved(angles, turns, pairs)

    moves, rows, new_of = joined(MOVES, ROWS, FOLDED, lambda turns: ALL, prove)
    assert moves == [MOVES[0], MOVES[1], MOVES[2] + MOVES[3]] and new_of == [0, 1, 2, 2]
    assert rows[:2] == ROWS[:2] and [row[0] for row in rows[2:]] == [2, 2]


def test_only_pairs_that_both_moves_move_are_proved_and_the_others_keep_their_own_intervals():
    pairs = {0: {(0, 1), (1, 2)}, 1: {(0, 2), (1, 2)}}
    rows = [(0, a, b, 0.0, 1.0, 0.1) for a, b in ((0, 1), (0, 2), (0, 3), (1, 2))] + [(1, a, b, 0.0, 1.0, 0.2) for a, b in ((0, 2), (1, 2))]
    asked = []

    def prove(angles, turns, both):
        asked.append(both)
        return [(0, 1, 2, 0.0, 1.0, 0.3)]

    found = joined(MOVES[:2], rows, FOLDED, lambda turns: set().union(*(pairs[min(angle, 1)] for angle, _, _ in turns)), prove)[1]
    assert asked == [[(1, 2)]]
    assert found == [(0, 0, 1, 0.0, 1.0, 0.1), (0, 0, 2, 0.0, 1.0, 0.2), (0, 0, 3, 0.0, 1.0, 0.1), (0, 1, 2, 0.0, 1.0, 0.3)]


def three_bones(**options):
    """A root and two arms; each turns by half a radian in the stand-in."""
    message, arrays = two_bones()
    message["options"].update(options)
    message["character"] = {"names": ["root", "arm", "hand"], "parents": [-1, 0, 1], "hinges": [[], [(0, -1.5, 1.5)], [(0, -1.5, 1.5)]]}
    arrays["heads"] = ("d", struct.pack("<9d", 0, 0, 0, 0, 1, 0, 0, 2, 0))
    arrays["tails"] = ("d", struct.pack("<9d", 0, 1, 0, 0, 2, 0, 0, 3, 0))
    arrays["axes"] = ("d", struct.pack("<27d", *IDENTITY, *IDENTITY, *IDENTITY))
    return message, arrays


@pytest.mark.parametrize("together, moves", [(True, 1), (False, 2)])
def test_a_design_lets_joints_turn_together_unless_it_is_told_not_to(together, moves):
    event = played(job_of(*three_bones(together=together)))[0][-1]
    assert event["kind"] == "result", event
    path, finishing = event["result"]["path"], event["result"]["finishing"]
    assert len(path["moves"]) == moves
    check_path(path["moves"], event["result"]["embedding"]["angles"])
    rows = struct.unpack(f"<{len(event['arrays']['certificate_intervals'][1]) // 8}d", bytes(event["arrays"]["certificate_intervals"][1]))
    assert {int(row) for row in rows[::6]} == set(range(moves))
    assert [(c["move"], c["angles"]) for c in path["collisions"]] == [(0, [0])]
    assert all(c["move"] < moves for c in path["collisions"]) and finishing["certificate"]["gap"] == pytest.approx(0.001)
