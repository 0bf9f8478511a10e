# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist steers and edits, on its way to the rooms. The native module is the stand-in."""
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import two_bones
from rooms import ALL, POSE, Ears
from transformables.core import pipeline
from transformables.core.options import UserError


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
