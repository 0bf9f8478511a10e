# SPDX-License-Identifier: GPL-3.0-or-later
import math

import pytest
from transformables.core import schedule
from transformables.core.schedule import check_path, eased, scheduled, together, uneased

PATH = [[(0, 1.0, 0.0)], [(1, -0.5, 0.5), (2, 0.5, -0.5)], [(1, 0.5, 0.0), (2, -0.5, 0.0)]]
FOLDED = [1.0, -0.5, 0.5]


def test_the_fold_goes_from_rest_to_the_folded_angles_in_reversed_order():
    plan = scheduled(PATH)
    assert plan.angles_at(1, 3) == [0, 0, 0]
    assert plan.angles_at(plan.last_frame, 3) == pytest.approx(FOLDED)
    assert [step.move for step in plan.steps] == [2, 1, 0]
    assert plan.steps[0].start == 1 and plan.steps[-1].end == plan.last_frame
    assert all(a.end == b.start for a, b in zip(plan.steps, plan.steps[1:]))


def test_only_the_joints_of_one_move_turn_at_a_time_and_at_the_same_rate():
    plan = scheduled(PATH)
    step = plan.steps[1]
    for t in (0.1, 0.35, 0.5, 0.9):
        angles = plan.angles_at(step.start + t * (step.end - step.start), 3)
        assert angles[0] == 0
        done = [(angles[a] - s) / (e - s) for a, s, e in step.turns]
        assert done == pytest.approx([eased(t)] * 2)


def test_keys_hold_a_joint_still_between_its_moves():
    plan = scheduled(PATH)
    for angle, curve in enumerate(plan.keys(3)):
        frames = [frame for frame, _, _ in curve]
        assert frames == sorted(set(frames)) and frames[0] == 1 and frames[-1] == plan.last_frame
        for (frame, value, moves_on), (_, following, _) in zip(curve, curve[1:]):
            assert plan.angles_at(frame, 3)[angle] == pytest.approx(value, abs=1e-12)
            assert moves_on or value == following


@pytest.mark.parametrize("count, degrees", [(1, 5), (18, 150), (60, 170), (200, 90)])
def test_an_automatic_fold_takes_a_watchable_time(count, degrees):
    plan = scheduled([[(i, math.radians(degrees), 0.0)] for i in range(count)])
    assert schedule.SHORTEST <= plan.last_frame <= max(schedule.LONGEST, schedule.LEAST_A_MOVE * count + 1)
    assert all(step.end - step.start >= schedule.LEAST_A_MOVE for step in plan.steps)


def test_a_fold_can_be_given_its_length():
    assert scheduled(PATH, frames=40).last_frame == 40
    assert scheduled(PATH, frames=2).last_frame == 4  # a frame a move at least


def test_a_loop_plays_there_and_back_and_shows_no_frame_twice():
    plan = scheduled(PATH, frames=40)
    assert plan.scene_end(False) == 40
    frames = plan.scene_end(True)
    there_and_back = [frame if frame <= 40 else 80 - frame for frame in range(1, frames + 2)]
    assert there_and_back[0] == there_and_back[-1] == 1, "the frame after the last is the first again"
    assert there_and_back[-2] == 2 and there_and_back.count(1) == 2 and there_and_back.count(40) == 1


def test_two_schedules_of_the_same_moves_have_matching_waypoints():
    short, long = scheduled(PATH, frames=10), scheduled(PATH, frames=500)
    assert len(short.waypoints()) == len(long.waypoints()) == len(PATH) + 1
    assert all(a < b for plan in (short, long) for a, b in zip(plan.waypoints(), plan.waypoints()[1:]))


def test_a_character_that_is_folded_as_it_stands_has_an_action_of_no_moves():
    plan = scheduled([])
    assert plan.last_frame > 1 and plan.angles_at(plan.last_frame, 2) == [0, 0]


def test_easing_is_undone_without_overshoot():
    values = [eased(i / 50) for i in range(51)]
    assert values == sorted(values) and values[0] == 0 and values[-1] == pytest.approx(1)
    assert [uneased(v) for v in values] == pytest.approx([i / 50 for i in range(51)], abs=1e-9)


def test_a_moment_of_a_move_has_its_frame():
    plan = scheduled(PATH)
    frame = plan.frame_of(1, 0.25)
    assert plan.angles_at(frame, 3)[1:] == pytest.approx([-0.25, 0.25])


@pytest.mark.parametrize("moves, words", [
    (PATH[:2], "away from rest"), ([[(0, 0.9, 0.0)], *PATH[1:]], "starts angle 0"), ([[(7, 1.0, 0.0)]], "turns angle 7")])
def test_a_path_that_jumps_or_does_not_end_at_rest_is_refused(moves, words):
    with pytest.raises(ValueError, match=words):
        check_path(moves, FOLDED)


def test_a_sound_path_and_a_path_of_everything_at_once_pass():
    check_path(PATH, FOLDED)
    check_path(together(FOLDED), FOLDED)
