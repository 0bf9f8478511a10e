# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's operators called by a script, with a real worker: they run to the end before they return."""
import os
import sys

import bpy
import pytest
from jobs import last

KILLED, BAD_INPUT = 3, 5  # seeds by which the stand-in module misbehaves


def _roles():
    return sorted(obj["transformable_role"] for obj in bpy.data.objects if "transformable_role" in obj)


def test_checking_the_character_tells_its_hinges(scene):
    assert bpy.ops.transformables.check_character() == {"FINISHED"}
    assert scene.transformables.character_stage.stored.splitlines() == ["3 of 3 bones are used", "2 hinges"]


def test_a_character_that_cannot_be_used_is_refused_in_words(scene):
    bpy.data.objects["Snake"].scale = (1, 2, 1)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="scaled unevenly"):
        bpy.ops.transformables.design()
    assert "scaled unevenly" in last().error
    assert _roles() == []


def test_an_option_that_does_not_fit_is_refused_in_words(scene):
    scene.transformables.target_stage.size_mm = 1
    scene.transformables.finishing_stage.clearance_mm = 5
    with pytest.raises(RuntimeError, match="clearance"):
        bpy.ops.transformables.design()
    assert "clearance" in last().error


def test_design_makes_the_rig_and_its_parts_and_keeps_pose_and_path(scene):
    assert bpy.ops.transformables.design() == {"FINISHED"}
    roles = _roles()
    assert roles.count("rig") == 1 and roles.count("part") >= 2
    assert last().error == "" and "parts" in last().summary
    from transformables.ui import fingerprint
    for stage in ("embedding", "segmentation", "folding"):
        group = getattr(scene.transformables, f"{stage}_stage")
        assert group.stored and fingerprint.fits(scene, stage, group.stored_for, thorough=True), stage


def test_designing_again_replaces_the_older_result(scene, stand_in):
    bpy.ops.transformables.design()
    first = _roles()
    bpy.ops.transformables.design()
    assert _roles() == first


def test_later_stages_start_from_the_stored_pose(scene, stand_in):
    assert bpy.ops.transformables.embed() == {"FINISHED"}
    assert _roles() == []
    pose = scene.transformables.embedding_stage.stored
    assert bpy.ops.transformables.plan_fold() == {"FINISHED"}
    from transformables.ui import results
    import json
    kept = results.stored(scene, ("embedding", "path"))
    assert kept["embedding"]["angles"] == json.loads(pose)["angles"]
    assert kept["path"]["moves"] == json.loads(scene.transformables.folding_stage.stored)["moves"]
    assert bpy.ops.transformables.finish() == {"FINISHED"}
    assert json.loads(scene.transformables.embedding_stage.stored)["angles"] == json.loads(pose)["angles"]


def test_an_error_of_the_worker_is_told_and_leaves_the_scene_alone(scene):
    flat = bpy.data.objects["Box"].data
    for vertex in flat.vertices:
        vertex.co.z = 0
    flat.update()
    before = {obj.name for obj in bpy.data.objects}
    with pytest.raises(RuntimeError, match="volume"):
        bpy.ops.transformables.design()
    assert "volume" in last().error
    assert {obj.name for obj in bpy.data.objects} == before and _roles() == []


def test_a_design_with_collisions_left_says_so_and_names_the_parts():
    from transformables.ui import results
    finishing = {"collisions": [{"bone_a": 2, "bone_b": 0}, {"bone_a": 0, "bone_b": 2}, {"bone_a": 1, "bone_b": 2}]}
    result = {"until": "finishing", "character": {"bodies": ["hip", "arm", "leg"]}, "finishing": finishing}
    assert results.collisions_left(result).startswith("Parts still collide on the way: arm with leg, hip with leg.")
    finishing["collisions"] = []
    assert results.collisions_left(result) == ""


@pytest.mark.parametrize("seed, words", [(KILLED, "worker process ended"), (BAD_INPUT, "its range is empty")])
def test_a_worker_that_fails_is_an_error_in_words_and_the_next_run_is_as_usual(scene, stand_in, seed, words):
    scene.transformables.embedding_stage.seed = seed
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.transformables.design()
    assert words in last().error and "\n" not in last().error
    assert _roles() == [] and scene.transformables.embedding_stage.stored == ""
    scene.transformables.embedding_stage.seed = 0
    assert bpy.ops.transformables.design() == {"FINISHED"}
    assert last().error == ""


if __name__ == "__main__":
    sys.stdout.flush()
    code = pytest.main(["-q", "-rs", "-p", "no:cacheprovider", os.path.abspath(__file__)])
    sys.stdout.flush()
    os._exit(int(code))


def test_a_preset_brings_back_the_settings_that_were_kept(scene, monkeypatch, tmp_path):
    real = bpy.utils.user_resource
    monkeypatch.setattr(bpy.utils, "user_resource", lambda kind, path="", create=False: str(tmp_path) if kind == "SCRIPTS" else real(kind, path=path, create=create))
    settings = scene.transformables
    settings.target_stage.size_mm, settings.finishing_stage.clearance_mm, settings.finishing_stage.style = 80, 0.5, "shell"
    assert bpy.ops.transformables.add_preset(name="Small Shell") == {"FINISHED"}
    written, = tmp_path.rglob("*.py")
    settings.target_stage.size_mm, settings.finishing_stage.style = 150, "solid"
    assert bpy.ops.script.execute_preset(filepath=str(written), menu_idname="TRANSFORMABLES_MT_presets") == {"FINISHED"}
    assert settings.target_stage.size_mm == pytest.approx(80) and settings.finishing_stage.style == "shell"
    assert settings.finishing_stage.clearance_mm == pytest.approx(0.5)


def test_the_folds_length_and_loop_can_be_changed_afterwards(scene, stand_in):
    assert not bpy.ops.transformables.retime.poll()
    scene.transformables.folding_stage.frames = 50
    bpy.ops.transformables.design()
    assert scene.frame_end == 50
    frame = scene.transformables.folding_stage.blocks[0].facts()["frame"]
    scene.transformables.folding_stage.frames, scene.transformables.folding_stage.loop = 99, True
    assert bpy.ops.transformables.retime() == {"FINISHED"}
    assert scene.frame_end == 2 * 99 - 2
    moved = scene.transformables.folding_stage.blocks[0].facts()["frame"]
    assert moved == pytest.approx(1 + (frame - 1) * 2, abs=1), "moments of pairs in the way move, too"
    with pytest.raises(RuntimeError, match="at least 2 frames"):
        scene.transformables.folding_stage.frames = 1
        bpy.ops.transformables.retime()


def test_the_slider_is_switched_on_and_off_from_the_panel(scene, stand_in):
    bpy.ops.transformables.design()
    rig = next(o for o in bpy.data.objects if o.get("transformable_role") == "rig")
    assert bpy.ops.transformables.fold_slider() == {"FINISHED"}
    assert rig["use_fold_slider"] == 1 and rig.animation_data.action is None
    scene.transformables.folding_stage.frames = 60
    assert bpy.ops.transformables.retime() == {"FINISHED"}, "also while the slider is on"
    assert bpy.ops.transformables.fold_slider() == {"FINISHED"}
    assert rig["use_fold_slider"] == 0 and rig.animation_data.action.frame_range[1] == 60


def test_parts_are_exported_for_printing_from_the_panel(scene, stand_in, tmp_path):
    assert not bpy.ops.transformables.export_parts.poll()
    bpy.ops.transformables.design()
    assert bpy.ops.transformables.export_parts(directory=str(tmp_path)) == {"FINISHED"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link0.stl", "link1.stl", "link2.stl"]
    assert bpy.ops.transformables.export_parts(directory=str(tmp_path), file_format="3mf") == {"FINISHED"}
    assert (tmp_path / "Snake_rig.3mf").exists()
    with pytest.raises(RuntimeError, match="No folder"):
        bpy.ops.transformables.export_parts()
