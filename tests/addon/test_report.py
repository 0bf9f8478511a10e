# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from jobs import job_of, played, two_bones
from transformables.core import report
from transformables.core.schedule import scheduled


@pytest.fixture(scope="module")
def result():
    return played(job_of(*two_bones()))[0][-1]["result"]


def built(result, **changes):
    result = {**result, "finishing": {**result["finishing"], **changes}}
    return report.build(result, scheduled(result["path"]["moves"]), "0.1.0", "3.4.1")


def test_the_report_has_what_the_contract_promises(result):
    made = built(result)
    assert {"version", "blender", "seconds", "bones", "grid", "resolution", "seed", "objective", "certified", "minimum_clearance_mm",
            "collisions", "carved_volume_pct", "filled_volume_pct", "folding_order", "peak_memory_mb", "warnings"} <= set(made)
    assert {"embedding", "segmentation", "folding", "finishing", "total"} <= set(made["seconds"])
    assert made["certified"] is True and made["collisions"] == []
    assert made["minimum_clearance_mm"] == pytest.approx(0.3)
    assert [(t["bone"], round(t["to_deg"], 3)) for t in made["folding_order"]] == [("arm", round(math.degrees(0.5), 3))]


def test_a_collision_is_told_with_its_pair_its_frame_and_cubic_millimetres(result):
    made = built(result, collisions=[{"bone_a": 0, "bone_b": 1, "move": 0, "fraction": 1.0, "volume": 1e-6}])
    assert made["certified"] is False
    (collision,) = made["collisions"]
    assert collision["bones"] == ["root", "arm"]
    assert collision["frame"] == 1  # a path is in unfolding order: its end is character mode
    assert collision["volume_mm3"] == pytest.approx(1e-6 * 300 ** 3)
    assert collision["angles"] == [{"bone": "arm", "axis": "X", "angle_deg": 0.0}]
    assert "'root' and 'arm' meet at frame 1" in report.collision_line(collision)


@pytest.mark.parametrize("hinges, names", [(True, ["arm"]), (False, [])])
def test_the_joints_that_have_a_pin_are_named(hinges, names):
    message, arrays = two_bones()
    message["options"]["hinges"] = hinges
    assert built(played(job_of(message, arrays))[0][-1]["result"])["pinned_joints"] == names


def test_a_preview_is_never_called_certified(result):
    assert built(result, preview=True)["certified"] is False


def test_only_a_proof_makes_a_design_certified(result):
    place = {"bone_a": 0, "bone_b": 1, "move": 0, "fraction": 0.5, "distance": 0.0001, "reason": "touching"}
    made = built(result, certificate={"holds": False, "gap": 0.0, "open": [place]}, minimum_clearance=0.0004)
    assert made["certified"] is False and made["collisions"] == []
    assert made["minimum_clearance_mm"] == pytest.approx(0.12)  # what samples show
    (told,) = made["uncertified"]
    assert told["bones"] == ["root", "arm"] and told["distance_mm"] == pytest.approx(0.03)
    assert "'root' and 'arm' touch at frame" in report.uncertified_line(told)
    proved = built(result, certificate={"holds": True, "gap": 0.0005, "open": []}, minimum_clearance=0.0004)
    assert proved["certified"] is True and proved["minimum_clearance_mm"] == pytest.approx(0.15)


def test_the_file_is_strict_json_whatever_the_numbers(result, tmp_path):
    made = built(result, minimum_clearance=math.inf, certificate=None)
    report.write(tmp_path / "r.json", made)
    read = json.loads((tmp_path / "r.json").read_text(), parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert read["minimum_clearance_mm"] is None
