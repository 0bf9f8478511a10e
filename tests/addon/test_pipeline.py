# SPDX-License-Identifier: GPL-3.0-or-later
"""The order of rooms, and what goes between them. The native module is the stand-in."""
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import STAND_IN, two_bones
from transformables.core import pipeline
from transformables.core.options import UserError

REHEARSAL = ["grow", "transfer", "fold"]
ALL = ["make_character", "make_target", "fitted", "explore", "make_target", *REHEARSAL, *REHEARSAL, *REHEARSAL, *REHEARSAL, "finish"]


class Ears:
    def __init__(self, stop_at=None):
        self.heard, self.warnings, self.poses, self.stop_at = [], [], [], stop_at

    def progress(self, stage, fraction, note=""):
        self.heard.append((stage, fraction))
        return stage != self.stop_at

    def pose(self, fields):
        self.poses.append(fields)

    def warning(self, text):
        self.warnings.append(text)

    def enough(self):
        return False


class SeenEnough(Ears):
    """Ends the job as soon as it has heard of a pose, and wants that."""

    def progress(self, stage, fraction, note=""):
        super().progress(stage, fraction, note)
        return not self.poses

    def enough(self):
        return bool(self.poses)


@pytest.fixture
def native(monkeypatch):
    monkeypatch.syspath_prepend(STAND_IN)
    monkeypatch.delitem(sys.modules, "transformables_native", raising=False)
    import transformables_native
    transformables_native.calls.clear()
    transformables_native.searches.clear()
    transformables_native.transfers.clear()
    transformables_native.budgets.clear()
    yield transformables_native
    sys.modules.pop("transformables_native")


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


def test_of_several_poses_the_one_that_loses_least_to_carving_is_taken(native, monkeypatch):
    fold = native.fold

    def costly(segmentation, character, target, embedding, **options):
        folding = fold(segmentation, character, target, embedding, **options)
        folding.carving_after = target.volume * {0.5: 0.2, 0.1: 0.15, 0.2: 0.05}[embedding.angles[0]]
        return folding

    monkeypatch.setattr(native, "fold", costly)
    result, _ = pipeline.run(*two_bones(), Ears())
    assert result["embedding"]["angles"] == [0.2]
    assert [turn[1] for move in result["path"]["moves"] for turn in move] == [0.2], "the path is that of the pose that was taken"


def grids_of_rehearsals(native, monkeypatch, **changes):
    """Resolutions that parts are grown at, one a rehearsal, with some functions of the native module replaced."""
    grow, grids = native.grow, []

    def noted(character, target, *rest, **options):
        grids.append(target.resolution)
        return grow(character, target, *rest, **options)

    monkeypatch.setattr(native, "grow", noted)
    for name, change in changes.items():
        made = getattr(native, name)
        monkeypatch.setattr(native, name, lambda *a, _made=made, _change=change, **k: _change(_made, *a, **k))
    pipeline.run(*two_bones(until="embedding"), Ears())
    return grids


def test_poses_are_told_apart_on_a_coarse_grid_and_the_one_taken_is_folded_on_the_fine_one(native, monkeypatch):
    assert grids_of_rehearsals(native, monkeypatch) == [40, 40, 40, 64]


def test_interfaces_are_rounded_off_only_for_the_pose_that_is_taken(native, monkeypatch):
    rounded = []

    def noting(made, *rooms, round_off, **more):
        rounded.append(round_off)
        return made(*rooms, round_off=round_off, **more)

    grids_of_rehearsals(native, monkeypatch, transfer=noting, fold=noting)
    assert rounded == [False, False] * 3 + [True, True]


def test_poses_are_told_apart_on_the_fine_grid_when_the_target_is_too_thin_for_a_coarse_one(native, monkeypatch):
    def too_thin(made, *, resolution, **given):
        if resolution < 64:
            raise native.InvalidInput("no voxels inside")
        return made(resolution=resolution, **given)

    assert grids_of_rehearsals(native, monkeypatch, make_target=too_thin) == 4 * [64]


@pytest.mark.parametrize("lost", [{"volume": 0.05}, {"scale": 0.3}, {"centre": [1.0, 2.0, 3.1]}])
def test_poses_are_told_apart_on_the_fine_grid_when_a_coarse_one_loses_much_of_the_target(native, monkeypatch, lost):
    def losing(made, *, resolution, **given):
        target = made(resolution=resolution, **given)
        if resolution < 64:
            vars(target).update(lost)
        return target

    assert grids_of_rehearsals(native, monkeypatch, make_target=losing) == 4 * [64]


@pytest.mark.parametrize("carving, searches", [(0.03, 1), (0.06, 2)])
def test_poses_that_lose_much_are_followed_by_a_second_search_elsewhere(native, monkeypatch, carving, searches):
    seeds, explore = [], native.explore

    def searched(*rooms, seed, **search):
        seeds.append(seed)
        return explore(*rooms, seed=seed, **search)

    def costly(made, segmentation, character, target, *rest, **more):
        folding = made(segmentation, character, target, *rest, **more)
        folding.carving_after = carving * target.volume
        return folding

    monkeypatch.setattr(native, "explore", searched)
    grids = grids_of_rehearsals(native, monkeypatch, fold=costly)
    assert len(seeds) == len(set(seeds)) == searches
    assert grids == searches * 3 * [40] + 2 * [64], "the two best of all are rehearsed well"


def test_a_pose_that_has_no_room_on_a_coarse_grid_is_rehearsed_on_the_fine_one(native, monkeypatch):
    def cramped(made, segmentation, character, target, embedding, **options):
        if target.resolution < 64 and embedding.angles[0] == 0.1:
            raise native.Infeasible("no room")
        return made(segmentation, character, target, embedding, **options)

    assert grids_of_rehearsals(native, monkeypatch, fold=cramped) == [40, 40, 64, 40, 64]
    with pytest.raises(native.Infeasible):
        grids_of_rehearsals(native, monkeypatch, fold=lambda *a, **k: (_ for _ in ()).throw(native.Infeasible("no room")))


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


POSE = {"root": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "angles": [0.7], "morphology": [1.0, 1.0]}


def test_exploring_gives_several_poses_each_with_lines_to_draw_and_what_is_wrong_with_it(native):
    result, _ = pipeline.run(*two_bones(until="embedding", explore={"count": 3, "least_difference": 0.2}), Ears())
    assert native.calls[-1] == "explore"
    assert [len(solution["points"]) for solution in result["solutions"]] == [4, 4, 4]
    assert result["solutions"][0]["outside"] == ["arm"] and result["solutions"][0]["colliding"] == [["root", "arm"]]
    assert result["embedding"]["angles"] == result["solutions"][0]["angles"]


def test_a_pair_to_be_kept_apart_decides_between_poses(native):
    plain, _ = pipeline.run(*two_bones(until="embedding"), Ears())
    steered, _ = pipeline.run(*two_bones(until="embedding", steering={"apart": [["root", "arm"]]}), Ears())
    assert plain["embedding"]["angles"] == [0.5]
    assert steered["embedding"]["angles"] == [0.1], "in the stand-in the least folded pose has least in the way"
    with pytest.raises(UserError, match="no bone 'tail'"):
        pipeline.run(*two_bones(steering={"apart": [["root", "tail"]]}), Ears())


def test_a_rival_stays_unless_the_search_beats_it(native):
    steering = {"apart": [["root", "arm"]]}
    ears = Ears()
    good = {**POSE, "angles": [0.01], "terms": {"total": 0.5}}
    kept, _ = pipeline.run(*two_bones(steering=steering, stored={"rival": good}), ears)
    assert kept["embedding"] == good and any("present one was kept" in text for text in ears.warnings)
    assert kept["path"]["moves"] == [[[0, 0.01, 0.0]]]
    ears = Ears()
    beaten, _ = pipeline.run(*two_bones(steering=steering, stored={"rival": {**POSE, "angles": [1.4]}}), ears)
    assert beaten["embedding"]["angles"] == [0.1] and not any("kept" in text for text in ears.warnings)


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


def test_what_is_steered_reaches_the_search(native):
    steering = {"weights": {"skin": 2}, "locked": ["arm"], "pinned": ["arm"], "proportions": {"root": [0.9, 1.1]}, "pose": POSE}
    pipeline.run(*two_bones(until="embedding", steering=steering), Ears())
    told = native.searches[0]
    assert told["weights"] == {"skin": 2.0} and told["locked"] == [(0, 0.7)] and told["proportion_of"] == [(0, 0.9, 1.1)]
    (bone, frame), = told["pinned"]
    assert bone == 1 and frame[12] == 1.0 and told["start"] is None


def test_a_search_from_a_pose_keeps_the_angles_of_that_pose(native):
    pipeline.run(*two_bones(until="embedding", stored={"start": POSE}, steering={"locked": ["arm"], "pose": {**POSE, "angles": [0.2]}}), Ears())
    assert native.searches[0]["locked"] == [(0, 0.7)] and native.searches[0]["start"].angles == [0.7]


def test_without_a_pose_a_locked_joint_stays_at_rest_and_a_pin_is_refused(native):
    pipeline.run(*two_bones(until="embedding", steering={"locked": ["arm"]}), Ears())
    assert native.searches[0]["locked"] == [(0, 0.0)]
    with pytest.raises(UserError, match="pinned bones need a folded pose"):
        pipeline.run(*two_bones(until="embedding", steering={"pinned": ["arm"]}), Ears())


@pytest.mark.parametrize("steering, words", [({"locked": ["tail"]}, "no bone 'tail'"), ({"frozen": []}, "not 'frozen'")])
def test_steering_that_means_nothing_is_refused(native, steering, words):
    with pytest.raises(UserError, match=words):
        pipeline.run(*two_bones(until="embedding", steering=steering), Ears())


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


def test_edits_are_replayed_after_transfer_and_transfer_heeds_them(native):
    message, arrays = two_bones(edits=[{"kind": "inhibit", "bone": "arm", "thickness_mm": 15.0},
                                       {"kind": "keep_whole", "name": "wheel", "faces": "edit_1_faces"}, {"kind": "remove", "bone": "nobody"}])
    arrays["edit_1_faces"] = ("d", bytes(72))
    ears = Ears()
    result, _ = pipeline.run(message, arrays, ears)
    names = [call if isinstance(call, str) else call[0] for call in native.calls]
    assert names == ALL[:-1] + ["edited", "transfer", "fold", "finish"]
    arm, wheel, nobody = native.calls[len(ALL) - 1][1]
    assert arm.reach == pytest.approx(0.05) and arm.bone == "arm"  # 15 of 150 mm, which are 0.5 target units
    assert wheel.painted == bytes(72) and wheel.name == "wheel"
    assert "edit remove was told of" in result["warnings"] and "edit remove was told of" in ears.warnings


def test_transfer_is_told_its_way_and_which_part_gives_room_at_a_joint(native):
    message, arrays = two_bones(until="segmentation", edits=[{"kind": "parent_gives", "bone": "arm"}, {"kind": "bone_gives", "bone": "root"},
                                                             {"kind": "bone_gives", "bone": "nobody"}])
    message["options"]["transfer"] = "exact"
    ears = Ears()
    result, _ = pipeline.run(message, arrays, ears)
    assert native.transfers and all(told == ("exact", {1: "to_child"}) for told in native.transfers)
    assert not any(call[0] == "edited" for call in native.calls if not isinstance(call, str)), "nothing is left to replay"
    assert [any(f"'{name}'" in text for text in result["warnings"]) for name in ("root", "nobody", "arm")] == [True, True, False]


def test_the_search_hears_of_edits_and_poses_that_miss_painted_regions_are_not_rehearsed(native, monkeypatch):
    explore = native.explore

    def missing(*rooms, **search):
        found = explore(*rooms, **search)
        found[0].missed, found[1].missed, found[2].missed = 0.1, 0.02, 0.0
        return found
    monkeypatch.setattr(native, "explore", missing)
    message, arrays = two_bones(until="segmentation", edits=[{"kind": "assign", "bone": "arm", "name": "nose", "faces": "f"}])
    arrays["f"] = ("d", bytes(72))
    result, _ = pipeline.run(message, arrays, Ears())
    assert [edit.name for edit in native.searches[-1]["edits"]] == ["nose"]
    assert result["embedding"]["angles"] == [0.2] and native.calls.count("fold") == 1
    assert [call[1][0].name for call in native.calls if not isinstance(call, str)] == ["nose"]


def test_an_edit_of_a_bone_that_is_fixed_to_another_goes_to_the_body_that_holds_it(native, monkeypatch):
    made = native.make_character
    def joined(**given):
        character = made(**given)
        character.names, character.members = character.names[:1], [[0, 1]]
        character.parents, character.hinges, character.angle_count, character.first_angle = [-1], [[]], 0, [0]
        return character
    monkeypatch.setattr(native, "make_character", joined)
    monkeypatch.setattr(native, "seams", lambda *_: [])  # a single part meets no other
    message, arrays = two_bones(until="segmentation", edits=[{"kind": "remove", "bone": "arm"}])
    pipeline.run(message, arrays, Ears())
    edits, = [call[1] for call in native.calls if not isinstance(call, str)]
    assert edits[0].bone == message["character"]["names"][0]


def test_seams_are_traced_as_edits_find_them_and_named_by_their_bones(native, monkeypatch):
    order = []
    for name in ("edited", "seams", "transfer"):
        made = getattr(native, name)
        monkeypatch.setattr(native, name, lambda *a, _name=name, _made=made, **k: (order.append(_name), _made(*a, **k))[1])
    result, arrays = pipeline.run(*two_bones(until="segmentation"), Ears())
    rehearsed = 4 * ["transfer"]
    assert order == [*rehearsed, "seams"]
    message, more = two_bones(until="segmentation", edits=[{"kind": "move_seam", "bone": "arm", "other": "root", "from": "f", "to": "t"}])
    more.update(f=("d", bytes(24)), t=("d", bytes(24)))
    order.clear()
    pipeline.run(message, more, Ears())
    assert order == [*rehearsed, "edited", "seams", "transfer"]
    seam, = result["seams"]
    assert seam["bones"] == message["character"]["names"] and seam["closed"] and len(arrays[seam["points"]][1]) == 120 * 8
