# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole way with the real native module, on a character of three bones: small, but nothing is made up."""
import json
import math
import os
import signal
import sys
import time

import bpy
import numpy as np
import pytest
import scenes
from transformables import cli
from transformables.bridge import design
from transformables.core import certificate, job
from transformables.core.options import DesignOptions

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "addon"))
import check_certificate  # noqa: E402

built = os.path.isdir(job.native_dir()) and any(n.startswith("transformables_native") for n in os.listdir(job.native_dir()))
pytestmark = pytest.mark.skipif(not built, reason="THE NATIVE MODULE IS NOT BUILT: no design was tried (run scripts/setup.sh)")
OPTIONS = DesignOptions(resolution=16)


@pytest.fixture
def scene(empty_scene):
    hinge = scenes.X_ONLY
    character = scenes.armature([("body", None, (0, 0, 0), (0, 1, 0), 0, None), ("front", "body", (0, 1, 0), (0, 2, 0), 0, hinge),
                                 ("back", "body", (0, 0, 0), (0, -1, 0), 0, hinge)], "folder")
    return character, scenes.cube("box", 2.0, (4, 5, 6))


def finished(scene, options=OPTIONS, on_event=None, **more):
    """The last event of a job on a scene."""
    message, arrays = design.gather(*scene, options)
    running = job.Job({**message, **more}, arrays)
    running.start()
    began = time.monotonic()
    while time.monotonic() - began < 120:
        for event in running.poll():
            if event["kind"] in ("result", "error"):
                return event
            if on_event:
                on_event(running, event)
        running.wait(0.05)
    running.close()
    pytest.fail("no end within 120 s")


def test_a_design_fills_the_target_and_folds_as_its_report_says(scene, tmp_path):
    code = cli.run(["design", "--resolution", "20", "--output", str(tmp_path / "o.blend"), "--report", str(tmp_path / "o.json")])
    report = json.loads((tmp_path / "o.json").read_text())
    assert code == (0 if report["certified"] else 3)
    assert report["filled_volume_pct"] > 80
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "o.blend"))
    parts = [o for o in bpy.data.objects if o.get("transformable_role") == "part"]
    assert {p["transformable_bone"] for p in parts} == {"body", "front", "back"}
    bpy.context.scene.frame_set(bpy.context.scene.frame_end)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    volume = 0.0
    for part in parts:
        world = np.array(part.evaluated_get(depsgraph).matrix_world)
        corners = np.array([v.co for v in part.data.vertices]) @ world[:3, :3].T + world[:3, 3]
        assert (np.abs(corners - (4, 5, 6)) < 1.01).all()  # in object mode all is inside the box
        t = corners[[tuple(p.vertices) for p in part.data.polygons]]
        volume += np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6
    assert 100 * volume / 8.0 == pytest.approx(report["filled_volume_pct"], abs=2)


def test_the_same_seed_gives_the_same_bytes_on_one_and_on_two_threads(scene):
    results = [finished(scene, DesignOptions(resolution=16, threads=threads)) for threads in (1, 2)]
    first, second = results
    assert first["arrays"] == second["arrays"]
    assert first["result"]["embedding"] == second["result"]["embedding"] and first["result"]["path"] == second["result"]["path"]


def test_an_independent_checker_replays_the_proof_of_joints_that_turn_together(scene):
    joined = 0
    for seed in range(4):
        event = finished(scene, DesignOptions(resolution=16, seed=seed))
        proof = certificate.document(event["result"], event["arrays"])
        joined += any(len(turns) > 1 for turns in proof["moves"])
        assert check_certificate.check(proof, rows=8)["intervals"] > 0
    assert joined >= 1, "or nothing was shown"


def test_stages_can_be_run_one_by_one(scene):
    pose = finished(scene, until="embedding")["result"]["embedding"]
    folded = finished(scene, until="folding", stored={"embedding": pose})["result"]
    event = finished(scene, stored={"embedding": pose})
    whole = finished(scene)
    assert event["result"]["path"]["moves"] == whole["result"]["path"]["moves"]
    turns = [[turn for move in moves for turn in move] for moves in (whole["result"]["path"]["moves"], folded["path"]["moves"])]
    assert turns[0] == turns[1], "finishing lets joints turn together, in the order that was planned"
    assert event["arrays"] == whole["arrays"]


def test_a_given_path_is_followed_to_the_letter(scene):
    folded = finished(scene, until="folding")["result"]
    moves = folded["path"]["moves"][::-1] if len(folded["path"]["moves"]) > 1 else folded["path"]["moves"]
    event = finished(scene, stored={"embedding": folded["embedding"], "path": {**folded["path"], "moves": moves}})
    assert event["kind"] == "result" and event["result"]["path"]["moves"] == moves


def test_vertices_that_are_no_numbers_are_dropped_and_told_or_refused_in_a_line(scene):
    scene[1].data.vertices[0].co.x = math.nan
    event = finished(scene)
    if event["kind"] == "result":
        assert event["result"]["warnings"]
    else:
        assert event["type"] == "InvalidInput" and "\n" not in event["text"]


def test_a_sheet_without_volume_is_refused_in_a_line(scene, tmp_path, capfd):
    sheet = scenes.mesh_object("sheet", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    assert cli.run(["design", "--target", sheet.name, "--output", str(tmp_path / "o.blend")]) == 2
    errors = [line for line in capfd.readouterr().err.splitlines() if "error:" in line]
    assert len(errors) == 1 and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("scale, rotation", [(0.01, (20, 30, 40)), (100, (0, 0, 0))])
def test_a_character_of_any_size_and_turn_is_designed(scene, scale, rotation):
    scenes.placed(scene[0], rotation, (7, 8, 9), (scale,) * 3)
    result = finished(scene)["result"]
    assert result["finishing"]["filled_volume_pct"] > 70


def test_names_of_any_letters_and_quotes_come_through(scene, tmp_path):
    scene[0].name, scene[1].name = 'W\u00e4chter "A" \'x\' 1.001', "Kiste \u00fc \u65e5\u672c"
    names = ['"one".001', "b'\\\\two", "\u00f6 [3]"]
    for bone, name in zip(list(scene[0].data.bones), names):
        bone.name = name
    out = tmp_path / "\u00fc o.blend"
    code = cli.run(["design", "--character", scene[0].name, "--target", scene[1].name, "--resolution", "16", "--output", str(out)])
    assert code in (0, 3)
    bpy.ops.wm.open_mainfile(filepath=str(out))
    rig = next(o for o in bpy.data.objects if o.get("transformable_role") == "rig")
    assert sorted(b.name for b in rig.data.bones) == sorted(names)
    channels = [c.data_path for c in rig.animation_data.action.fcurves]
    assert channels and all(rig.path_resolve(path) is not None for path in channels)


def test_an_empty_mesh_is_refused(scene):
    empty = scenes.mesh_object("empty", [], [])
    event = finished((scene[0], empty))
    assert event["kind"] == "error" and event["type"] == "InvalidInput"


@pytest.mark.parametrize("stage", ["target", "embedding", "segmentation", "folding", "finishing"])
def test_cancel_works_at_every_stage_within_a_second(scene, stage):
    cancelled = []

    def cancel(running, event):
        if event.get("stage") == stage and not cancelled:
            cancelled.append(time.monotonic())
            running.cancel()

    event = finished(scene, on_event=cancel)
    assert event["kind"] == "error" and event["type"] == "Cancelled"
    assert time.monotonic() - cancelled[0] < 1.0


@pytest.mark.parametrize("explore", [None, {"count": 40, "least_difference": 0.01}])
def test_a_search_streams_its_poses_and_a_stopped_one_keeps_the_best(scene, explore):
    told, asked = [], []

    def stop_after_a_while(running, event):
        if event["kind"] == "pose":
            told.append((time.monotonic(), event["value"]))
        if len(told) >= 8 and not asked:
            asked.append(time.monotonic())
            running.stop()

    event = finished(scene, DesignOptions(resolution=48), on_event=stop_after_a_while, until="embedding", **({"explore": explore} if explore else {}))
    took, streamed = time.monotonic() - asked[0], (told[7][0] - told[0][0]) / 7
    print(f"poses came {streamed:.2f} s apart, the end {1000 * took:.0f} ms after it was asked for")
    assert event["kind"] == "result" and event["result"]["stopped"]
    pose = event["result"]["embedding"]
    assert np.isfinite(pose["angles"]).all() and pose["value"] <= told[0][1]
    assert bool(event["result"]["solutions"]) == bool(explore)
    assert took < 1.0


def test_a_killed_worker_is_an_error_in_words_and_the_scene_is_as_before(scene):
    before = {o.name for o in bpy.data.objects}
    event = finished(scene, on_event=lambda running, e: e.get("stage") == "embedding" and os.kill(running.pid, signal.SIGKILL))
    assert event["type"] == "WorkerDied" and "out of memory" in event["text"]
    assert {o.name for o in bpy.data.objects} == before


def test_running_out_of_memory_is_an_error_in_words(scene):
    event = finished(scene, DesignOptions(resolution=400), memory_limit_mb=300)
    assert event["kind"] == "error" and event["type"] in ("OutOfMemory", "WorkerDied")
    assert "lower resolution" in event["text"]
