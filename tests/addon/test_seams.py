# SPDX-License-Identifier: GPL-3.0-or-later
"""How a pull at a seam's point moves its neighbours."""
import math
import random

import pytest

from transformables.core import seams

ROUND = [(math.cos(a), math.sin(a), 0.0) for a in (2 * math.pi * k / 60 for k in range(60))]


def test_ways_along_a_closed_curve_take_the_shorter_side():
    ways = seams.along(ROUND, True, 5)
    assert ways[5] == 0 and max(ways) == pytest.approx(math.pi, rel=0.01)
    assert ways[4] == pytest.approx(ways[6]) and ways[59] == pytest.approx(ways[11])
    assert max(seams.along(ROUND, False, 0)) > 1.9 * math.pi


@pytest.mark.parametrize("closed", (True, False))
def test_the_pulled_point_follows_wholly_and_others_less_with_their_distance(closed):
    for size in (0.2, 1.0, 9.0):
        index = random.Random(1).randrange(60)
        ways, weights = seams.along(ROUND, closed, index), seams.weights(ROUND, closed, index, size)
        assert weights[index] == 1
        assert all(w == 0 for way, w in zip(ways, weights) if way >= size)
        ordered = [w for _, w in sorted(zip(ways, weights))]
        assert ordered == sorted(ordered, reverse=True)


def test_without_size_only_the_pulled_point_follows():
    moved = seams.pulled(ROUND, True, 7, (0, 0, 1), 0, lambda p: p)
    assert [i for i, (a, b) in enumerate(zip(ROUND, moved)) if a != b] == [7]


def test_moved_points_are_put_back_on_the_surface_and_others_left_alone():
    on_surface = lambda p: tuple(x / math.dist(p, (0, 0, 0)) for x in p)  # noqa: E731
    moved = seams.pulled(ROUND, True, 0, (0, 0, 0.5), 1.0, on_surface)
    assert all(math.dist(p, (0, 0, 0)) == pytest.approx(1) for p in moved)
    assert moved[30] == ROUND[30] and moved[0][2] > 0.4


def test_what_is_sent_holds_the_seam_on_both_sides_of_the_pull():
    moved = seams.pulled(ROUND, True, 0, (0, 0, 0.5), 0.25, lambda p: p)
    assert seams.worth_sending(ROUND, moved, 3) == [0, 1, 2, 3, 4, 5, 55, 56, 57, 58, 59]
    assert seams.worth_sending(ROUND, ROUND, 3) == []
