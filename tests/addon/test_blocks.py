# SPDX-License-Identifier: GPL-3.0-or-later
"""Which pairs are in each other's way: what a list of them has to say, from results made by hand."""
import math
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import job_of, played, two_bones
from transformables.core import blocks
from transformables.core.schedule import scheduled

MM3 = 300.0 ** 3  # of a cubic target unit at the usual size


@pytest.fixture(scope="module")
def result():
    return played(job_of(*two_bones()))[0][-1]["result"]


def met(a, b, swept, fraction=0.5, **more):
    return {"bone_a": a, "bone_b": b, "move": 0, "fraction": fraction, "volume": swept / 2, "swept": swept, **more}


def rows(result, carved=(), left=(), open_places=(), preview=False):
    finishing = {**result["finishing"], "collisions": list(left), "preview": preview,
                 "certificate": None if preview else {"holds": not open_places, "gap": 0.001, "open": list(open_places)}}
    changed = {**result, "finishing": finishing, "path": {**result["path"], "collisions": list(carved)}}
    changed["character"] = {**result["character"], "bodies": ["root", "arm", "leg"]}
    return blocks.blocks(changed, scheduled(result["path"]["moves"]))


def test_a_finished_design_lists_what_each_pair_cost_dearest_first_one_row_a_pair(result):
    first, second = rows(result, [met(0, 1, 2e-5), met(0, 2, 2e-5, 0.2), met(0, 2, 5e-5, 0.8, place=[0.0, 0.1, 0.0])])
    assert first["bones"] == ["root", "leg"] and second["bones"] == ["root", "arm"]
    assert first["state"] == second["state"] == blocks.CARVED
    assert first["volume_mm3"] == pytest.approx(7e-5 * MM3) and second["volume_mm3"] == pytest.approx(2e-5 * MM3)
    plan = scheduled(result["path"]["moves"])
    assert first["frame"] == pytest.approx(plan.frame_of(0, 0.8), abs=1e-3), "the pair's worst moment"
    assert first["place"] == pytest.approx([0, 0.1 / result["target"]["scale"], 0])
    assert second["place"] is None
    (joint,) = first["joints"]
    assert (joint["bone"], joint["axis"], joint["angle"]) == ("arm", "X", 0)
    assert joint["angle_deg"] == pytest.approx(math.degrees(plan.angles_at(first["frame"], 1)[0]), abs=1e-3)


def test_what_still_meets_comes_before_what_is_not_proved_and_both_before_what_was_carved(result):
    place = {"bone_a": 1, "bone_b": 0, "move": 0, "fraction": 0.5, "distance": 0.0, "reason": "touching", "place": [0.1, 0.0, 0.0]}
    unproved = {**place, "bone_a": 0, "bone_b": 2, "reason": "unresolved"}
    found = rows(result, [met(0, 1, 1e-4), met(0, 2, 1e-4), met(1, 2, 1e-4)], [met(0, 1, 0.0)], [unproved, place])
    assert [(row["bones"], row["state"]) for row in found] == [
        (["root", "arm"], blocks.MEETS), (["root", "leg"], blocks.UNPROVED), (["arm", "leg"], blocks.CARVED)]
    assert found[0]["place"] is None, "a place on the other bone is of no use on this one"


def test_the_place_of_a_proof_that_failed_is_that_of_the_collision(result):
    place = {"bone_a": 0, "bone_b": 1, "move": 0, "fraction": 0.5, "distance": 0.0, "reason": "touching", "place": [0.1, 0.0, 0.0]}
    (row,) = rows(result, left=[met(0, 1, 0.0)], open_places=[place])
    assert row["place"] == pytest.approx([0.1 / result["target"]["scale"], 0, 0])


def test_a_fold_that_is_only_planned_lists_what_is_to_be_carved(result):
    (row,) = rows(result, [met(0, 1, 1e-4)], preview=True)
    assert row["state"] == blocks.TO_CARVE and "to carve" in blocks.words(row)


def test_what_costs_next_to_nothing_is_not_listed(result):
    assert rows(result, [met(0, 1, 1e-6 * result["target"]["volume"])]) == []


def test_a_design_without_a_path_has_no_rows(result):
    assert blocks.blocks({**result, "path": None}, scheduled([])) == []


def test_every_state_has_its_sentence_with_both_names_the_frame_and_the_joint(result):
    (row,) = rows(result, [met(0, 1, 1e-4)])
    sentences = {blocks.words({**row, "state": state}) for state in blocks.STATES}
    assert len(sentences) == len(blocks.STATES)
    for text in sentences:
        assert text.startswith("root and arm") and f"frame {row['frame']:.0f}" in text and "arm at " in text


def test_of_joints_that_turn_together_only_those_are_named_that_the_pair_met_by(result):
    assert [joint["angle"] for joint in rows(result, [met(0, 1, 1e-4, angles=[0])])[0]["joints"]] == [0]
    assert rows(result, [met(0, 1, 1e-4, angles=[5])])[0]["joints"] == []


def test_volumes_are_told_in_units_that_are_easily_read():
    assert [blocks.volume_words(v) for v in (5400.0, 120.4, 3.14)] == ["5.4 cm³", "120 mm³", "3.1 mm³"]


def test_a_pairs_share_counts_all_its_meetings_whichever_way_round():
    path = {"collisions": [met(0, 1, 0.25), met(1, 0, 0.5), met(0, 2, 4.0)]}
    assert blocks.share_of(path, (1, 0), 3.0) == pytest.approx(0.25)
