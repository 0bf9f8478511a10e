# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of several folded poses is taken, and on which grid that is found out. The native module is the stand-in."""
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import two_bones
from rooms import POSE, Ears
from transformables.core import pipeline
from transformables.core.options import UserError


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


@pytest.mark.parametrize("second, grids", [(0.08, [40, 40, 40, 64]), (0.07, [40, 40, 40, 64, 64])])
def test_a_second_pose_is_rehearsed_well_only_when_it_did_not_lose_far_more_roughly(native, monkeypatch, second, grids):
    def costly(made, segmentation, character, target, embedding, **more):
        folding = made(segmentation, character, target, embedding, **more)
        lost = {0.5: 0.04, 0.1: second, 0.2: 0.2}[embedding.angles[0]] if target.resolution < 64 else 0.05
        folding.carving_after = lost * target.volume
        return folding

    assert grids_of_rehearsals(native, monkeypatch, fold=costly) == grids


def test_a_pose_that_has_no_room_on_a_coarse_grid_is_rehearsed_on_the_fine_one(native, monkeypatch):
    def cramped(made, segmentation, character, target, embedding, **options):
        if target.resolution < 64 and embedding.angles[0] == 0.1:
            raise native.Infeasible("no room")
        return made(segmentation, character, target, embedding, **options)

    assert grids_of_rehearsals(native, monkeypatch, fold=cramped) == [40, 40, 64, 40, 64]
    with pytest.raises(native.Infeasible):
        grids_of_rehearsals(native, monkeypatch, fold=lambda *a, **k: (_ for _ in ()).throw(native.Infeasible("no room")))


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
