# SPDX-License-Identifier: GPL-3.0-or-later
"""The order of rooms, and what goes between them. The native module is the stand-in."""
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import two_bones
from rooms import ALL, Ears, SeenEnough
from transformables.core import pipeline
from transformables.core.options import UserError


def test_rooms_follow_each_other_and_every_stage_is_timed(native):
    ears = Ears()
    result, arrays = pipeline.run(*two_bones(), ears)
    assert native.calls == ALL
    assert {"embedding", "segmentation", "folding", "finishing", "total"} <= set(result["seconds"])
    assert result["peak_memory_mb"] > 1
    assert {"heads", "tails", "axes", "rotation", "part_0_vertices", "part_1_triangles"} <= set(arrays)
    for stage in pipeline.STAGES:
        fractions = [f for s, f in ears.heard if s == stage]
        assert fractions == sorted(fractions) and fractions[0] == 0 and fractions[-1] == 1


@pytest.mark.parametrize("more", [{}, {"explore": {"count": 3, "least_difference": 0.1}}])
def test_a_search_that_is_stopped_gives_its_best_so_far_unless_more_than_a_pose_was_asked_for(native, more):
    ears = SeenEnough()
    result, _ = pipeline.run(*two_bones(until="embedding", **more), ears)
    assert result["stopped"] and result["embedding"]["angles"] == ears.poses[0]["angles"]
    assert len(result["solutions"]) == (1 if more else 0)
    assert "grow" not in native.calls
    with pytest.raises(native.Cancelled):
        pipeline.run(*two_bones(**more), SeenEnough())


@pytest.mark.parametrize("until, calls", [
    ("embedding", ALL[:-1]), ("segmentation", ALL), ("folding", ALL)])  # a pose is chosen by how it unfolds
def test_a_job_ends_where_it_is_told_to_and_shows_parts_as_soon_as_there_are_any(native, until, calls):
    result, _ = pipeline.run(*two_bones(until=until), Ears())
    assert native.calls == calls
    assert (result["finishing"] is None) == (until == "embedding")
    assert (result["path"] is None) == (until in ("embedding", "segmentation"))


def test_what_is_stored_is_not_searched_again(native):
    first, _ = pipeline.run(*two_bones(), Ears())
    native.calls.clear()
    message, arrays = two_bones(stored={"embedding": first["embedding"], "path": first["path"]})
    second, _ = pipeline.run(message, arrays, Ears())
    assert "explore" not in native.calls and "fold" not in native.calls
    assert second["embedding"] == first["embedding"] and second["path"]["moves"] == first["path"]["moves"]


def test_a_stored_pose_of_another_character_is_refused(native):
    first, _ = pipeline.run(*two_bones(until="embedding"), Ears())
    stored = {"embedding": {**first["embedding"], "angles": [0.1, 0.2]}}
    with pytest.raises(UserError, match="another character"):
        pipeline.run(*two_bones(stored=stored), Ears())


def test_a_stored_path_from_another_pose_is_refused(native):
    first, _ = pipeline.run(*two_bones(), Ears())
    stored = {"embedding": first["embedding"], "path": {**first["path"], "moves": [[[0, 1.25, 0.0]]]}}
    with pytest.raises(UserError, match="run the folding stage again"):
        pipeline.run(*two_bones(stored=stored), Ears())


@pytest.mark.parametrize("stage", pipeline.STAGES)
def test_every_stage_can_be_stopped(native, stage):
    with pytest.raises((pipeline.Cancelled, native.Cancelled)):
        pipeline.run(*two_bones(), Ears(stop_at=stage))


def test_the_best_pose_is_told_as_lines_in_blenders_world(native):
    ears = Ears()
    pipeline.run(*two_bones(), ears)
    root_head, root_tail, arm_head, arm_tail = ears.poses[0]["points"]
    assert root_head == pytest.approx((1.0 + 0.1 / 0.25, 2.0, 3.0))  # root in target units, over scale, from the centre
    assert arm_head == pytest.approx(root_tail)
    bone = 0.5 / 0.25  # fit scale over target scale, times a length of 1
    assert arm_head[1] - root_head[1] == pytest.approx(bone)
    assert sum((a - b) ** 2 for a, b in zip(arm_head, arm_tail)) ** 0.5 == pytest.approx(bone)


def test_an_unknown_end_is_refused(native):
    with pytest.raises(UserError):
        pipeline.run(*two_bones(until="painting"), Ears())


def test_exploring_gives_several_poses_each_with_lines_to_draw_and_what_is_wrong_with_it(native):
    result, _ = pipeline.run(*two_bones(until="embedding", explore={"count": 3, "least_difference": 0.2}), Ears())
    assert native.calls[-1] == "explore"
    assert [len(solution["points"]) for solution in result["solutions"]] == [4, 4, 4]
    assert result["solutions"][0]["outside"] == ["arm"] and result["solutions"][0]["colliding"] == [["root", "arm"]]
    assert result["embedding"]["angles"] == result["solutions"][0]["angles"]


def test_the_target_time_of_the_fold_is_a_number_of_tries_and_a_limit(native):
    for seconds, tries in ((20.0, 3000), (40.0, 6000), (0.1, 15)):
        native.budgets.clear()
        message, arrays = two_bones()
        message["options"]["fold_seconds"] = seconds
        pipeline.run(message, arrays, Ears())
        assert native.budgets[-1] == (tries, seconds)
        assert all(limit == seconds for _, limit in native.budgets), "rehearsals, too, end in time"


def test_a_search_that_was_stopped_by_the_clock_is_told(native, monkeypatch):
    real = native.fold

    def slow(*arguments, **more):
        folding = real(*arguments, **more)
        folding.path.cut_short = True
        return folding

    ears = Ears()
    pipeline.run(*two_bones(), ears)
    assert not any("stopped after" in text for text in ears.warnings)
    monkeypatch.setattr(native, "fold", slow)
    pipeline.run(*two_bones(), ears)
    assert len([text for text in ears.warnings if "stopped after 20 s" in text]) == 1


@pytest.mark.parametrize("left", [0, 1])
def test_a_design_of_one_part_is_no_design(native, monkeypatch, left):
    finish = native.finish

    def nearly_nothing(*words, **options):
        finished = finish(*words, **options)
        del finished.parts[left:]
        return finished

    monkeypatch.setattr(native, "finish", nearly_nothing)
    with pytest.raises(UserError, match=f"of 2 parts only {left} would be left"):
        pipeline.run(*two_bones(), Ears())
