# SPDX-License-Identifier: GPL-3.0-or-later
"""The headless command: its words, exit codes and files. Where a worker is needed, its native module is the stand-in."""
import json
import math
import os
import signal

import bpy
import pytest
import scenes
from stand_in import transformables_native as stand_in
from transformables import cli
from transformables.core import job


@pytest.fixture(autouse=True)
def stand_in_module(monkeypatch):
    folder = os.path.dirname(stand_in.__file__)
    monkeypatch.setattr(job, "native_dir", lambda: folder)


@pytest.fixture
def scene(empty_scene):
    return scenes.walker(), scenes.cube("box", 2.0, (4, 5, 6))


def told(capfd):
    """What was said on standard error, without Blender's own lines."""
    return [line for line in capfd.readouterr().err.splitlines() if line.startswith("transformables: ")]


def refused(capfd, tmp_path, *words):
    """Runs the command, which has to refuse: exit code 2, one line, no file. Gives the line."""
    assert cli.run(["design", *words]) == 2
    lines = told(capfd)
    assert len(lines) == 1 and lines[0].startswith("transformables: error: ")
    assert list(tmp_path.iterdir()) == []
    return lines[0]


def outputs(tmp_path):
    return ["--output", str(tmp_path / "out.blend"), "--report", str(tmp_path / "out.json")]


def test_a_design_is_written_with_its_report_and_progress_is_told(scene, tmp_path, capfd):
    assert cli.run(["design", *outputs(tmp_path)]) == 0
    lines = told(capfd)
    for stage in ("character", "target", "embedding", "segmentation", "folding", "finishing"):
        assert any(line.startswith(f"transformables: {stage}: ") for line in lines)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.blend", "out.json"]
    report = json.loads((tmp_path / "out.json").read_text())
    assert report["certified"] and report["blender"] == bpy.app.version_string and report["seconds"]["total"] > 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    roles = [o.get("transformable_role") for o in bpy.data.objects]
    assert roles.count("rig") == roles.count("character") == roles.count("target") == 1 and roles.count("part") == 8


def test_one_of_both_files_is_enough(scene, tmp_path):
    assert cli.run(["design", "--report", str(tmp_path / "r.json")]) == 0
    assert [p.name for p in tmp_path.iterdir()] == ["r.json"]


def test_a_finished_file_can_be_designed_again(scene, tmp_path):
    assert cli.run(["design", "--output", str(tmp_path / "out.blend")]) == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert cli.run(["design", "--output", str(tmp_path / "out.blend")]) == 0
    assert [p.name for p in tmp_path.iterdir()] == ["out.blend"]
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert [o.get("transformable_role") for o in bpy.data.objects].count("rig") == 1


@pytest.mark.parametrize("option, name, words", [
    ("--character", "nobody", ["no armature 'nobody'", "'walker'"]), ("--character", "box", ["'box' is not an armature", "'walker'"]),
    ("--target", "nothing", ["no mesh object 'nothing'", "'box'"]), ("--target", "walker", ["'walker' is not a mesh", "'box'"])])
def test_a_wrong_name_is_told_with_the_names_that_there_are(scene, tmp_path, capfd, option, name, words):
    line = refused(capfd, tmp_path, option, name, *outputs(tmp_path))
    assert all(w in line for w in words)


def test_several_candidates_are_listed_where_none_was_named(scene, tmp_path, capfd):
    scenes.cube("crate", 1.0)
    line = refused(capfd, tmp_path, *outputs(tmp_path))
    assert "'box', 'crate'" in line and "--target" in line


def test_a_file_without_candidates_is_refused(empty_scene, tmp_path, capfd):
    assert "no armature" in refused(capfd, tmp_path, *outputs(tmp_path))
    scenes.walker()
    assert "no mesh object" in refused(capfd, tmp_path, *outputs(tmp_path))


@pytest.mark.parametrize("words, says", [
    (["--resolution", "3"], "resolution is 3"), (["--resolution", "many"], "--resolution"), (["--symmetry", "maybe"], "--symmetry"),
    (["--simplify", "some"], "simplify"), (["--colour", "red"], "--colour"), (["--clearance", "nan"], "clearance"), (["--size", "-1"], "size")])
def test_a_wrong_option_is_one_line(scene, tmp_path, capfd, words, says):
    assert says in refused(capfd, tmp_path, *words, *outputs(tmp_path))


def test_without_anything_to_write_nothing_is_done(scene, tmp_path, capfd):
    assert "--output" in refused(capfd, tmp_path)


def test_a_word_that_is_no_command_is_refused(capfd):
    assert cli.run(["paint"]) == 2 and cli.run([]) == 2
    assert len(told(capfd)) == 2


@pytest.mark.parametrize("place", ["no/such/folder/x.blend", "file/x.blend", "."])
@pytest.mark.parametrize("option", ["--output", "--report"])
def test_a_place_that_cannot_be_written_is_told_before_the_work_starts(scene, tmp_path, capfd, monkeypatch, place, option):
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "file").write_text("not a folder")
    monkeypatch.setattr(job.Job, "start", lambda self: pytest.fail("the work was started"))
    assert cli.run(["design", option, str(folder / place)]) == 2
    lines = told(capfd)
    assert len(lines) == 1 and option in lines[0]
    assert [p.name for p in folder.iterdir()] == ["file"]


def test_the_two_files_must_differ(scene, tmp_path, capfd):
    assert "same file" in refused(capfd, tmp_path, "--output", str(tmp_path / "x"), "--report", str(tmp_path / "x"))


def test_when_writing_fails_the_older_file_stays_and_no_half_one(scene, tmp_path, capfd, monkeypatch):
    (tmp_path / "out.blend").write_bytes(b"older")

    def full(*_):
        raise OSError(28, "No space left on device")

    from transformables.core import report
    monkeypatch.setattr(report, "write", full)
    assert cli.run(["design", *outputs(tmp_path)]) == 2
    assert "No space left" in told(capfd)[-1]
    assert [(p.name, p.read_bytes()) for p in tmp_path.iterdir()] == [("out.blend", b"older")]


@pytest.mark.parametrize("behaviour, says", [
    (stand_in.KILLED, "probably out of memory"), (stand_in.BAD_INPUT, "its range is empty"), (stand_in.INFEASIBLE, "does not fit")])
def test_a_job_that_ends_without_a_design_is_told_in_a_line(scene, tmp_path, capfd, behaviour, says):
    assert cli.run(["design", "--seed", str(behaviour), *outputs(tmp_path)]) == 2
    errors = [line for line in told(capfd) if "error:" in line]
    assert len(errors) == 1 and says in errors[0]
    assert list(tmp_path.iterdir()) == []


def test_a_fault_exits_1_and_writes_nothing(scene, tmp_path, capfd):
    assert cli.run(["design", "--seed", str(stand_in.FAULT), *outputs(tmp_path)]) == 1
    assert list(tmp_path.iterdir()) == []


def test_collisions_that_are_left_are_told_and_exit_3(scene, tmp_path, capfd, monkeypatch):
    from transformables.bridge import design
    apply = design.apply

    def colliding(context, result, *rest):
        result["finishing"]["collisions"] = [{"bone_a": 0, "bone_b": 2, "move": 1, "fraction": 0.5, "volume": 1e-6}]
        return apply(context, result, *rest)

    monkeypatch.setattr(design, "apply", colliding)
    assert cli.run(["design", *outputs(tmp_path)]) == 3
    report = json.loads((tmp_path / "out.json").read_text())
    assert report["certified"] is False and report["collisions"][0]["volume_mm3"] > 0 and report["collisions"][0]["angles"]
    assert any("meet at frame" in line for line in told(capfd))
    assert (tmp_path / "out.blend").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_being_stopped_writes_nothing_and_puts_the_signals_back(scene, tmp_path, capfd, monkeypatch, number):
    poll, before = job.Job.poll, signal.getsignal(number)

    def interrupted(self):
        events = poll(self)
        if any(e.get("stage") == "embedding" for e in events):
            os.kill(os.getpid(), number)
        return events

    monkeypatch.setattr(job.Job, "poll", interrupted)
    assert cli.run(["design", "--seed", str(stand_in.DEAF), *outputs(tmp_path)]) == 130
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(number) in (before, signal.SIG_DFL)


def test_vertices_that_are_no_numbers_are_passed_on_for_judgement(scene):
    from transformables.bridge import design
    from transformables.core.options import DesignOptions
    scene[1].data.vertices[0].co.x = math.nan
    message, arrays = design.gather(*scene, DesignOptions())
    assert math.isfinite(message["target"]["floor"])
    import numpy as np
    assert np.isnan(np.frombuffer(arrays["vertices"][1])).any()


def test_a_target_too_small_for_blenders_bones_is_refused(scene, tmp_path, capfd):
    scene[1].scale = (1e-4, 1e-4, 1e-4)
    assert "scale it up" in refused(capfd, tmp_path, *outputs(tmp_path))


def test_help_exits_0(capsys):
    assert cli.run(["design", "--help"]) == 0
    words = capsys.readouterr().out
    for option in ("--character", "--target", "--resolution", "--seed", "--symmetry", "--simplify", "--fit", "--proportions", "--size",
                   "--clearance", "--style", "--wall", "--output", "--report"):
        assert option in words


@pytest.mark.parametrize("place, told_of", [((1e5, 0, 0), True), ((1000, 0, 0), False)])
def test_a_target_that_lies_very_far_out_for_its_size_is_designed_with_a_warning(scene, tmp_path, capfd, place, told_of):
    scene[1].location = place
    assert cli.run(["design", *outputs(tmp_path)]) == 0
    report = json.loads((tmp_path / "out.json").read_text())
    assert any("very far for its size" in w for w in report["warnings"]) == told_of


def test_parts_are_written_for_printing_into_a_folder_that_is_made(scene, tmp_path, capfd):
    assert cli.run(["design", "--parts", str(tmp_path / "a" / "b"), "--report", str(tmp_path / "r.json")]) == 0
    names = sorted(p.name for p in (tmp_path / "a" / "b").iterdir())
    assert len(names) == 9 and "thigh.L.stl" in names and sum(name.endswith(".stl") for name in names) == 8
    assert json.loads((tmp_path / "r.json").read_text())["pinned_joints"], "so there is one file of all in their places, too"
    assert [name for name in names if name.endswith("_assembled.3mf")]


def test_without_pins_no_file_of_parts_in_their_places_is_written(scene, tmp_path, capfd):
    assert cli.run(["design", "--hinges", "off", "--parts", str(tmp_path / "parts")]) == 0
    assert all(p.name.endswith(".stl") for p in (tmp_path / "parts").iterdir())


def test_a_parts_folder_that_cannot_be_made_is_refused_before_the_work(scene, tmp_path, capfd):
    (tmp_path / "file").write_text("")
    assert cli.run(["design", "--parts", str(tmp_path / "file" / "b"), "--report", str(tmp_path / "r.json")]) == 2
    (line,) = told(capfd)
    assert "--parts" in line and "folder that you may write to" in line
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_length_and_loop_of_the_fold_are_the_commands(scene, tmp_path):
    assert cli.run(["design", "--frames", "40", "--loop", "on", "--fold-seconds", "5", *outputs(tmp_path)]) == 0
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end) == (1, 78)
    report = json.loads((tmp_path / "out.json").read_text())
    assert report["frames"] == [1, 40] and report["options"]["fold_seconds"] == 5
