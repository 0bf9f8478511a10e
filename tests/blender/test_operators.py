# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's operators called by a script, with a real worker: they run to the end before they return."""
import os
import sys

import bpy  # first: it makes addon_utils findable
import addon_utils
import pytest

ADDON = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "addon")
if ADDON not in sys.path:
    sys.path.insert(0, ADDON)

STAND_IN = os.path.join(os.path.dirname(ADDON), "tests", "addon", "stand_in")
KILLED, BAD_INPUT = 3, 5  # seeds by which the stand-in module misbehaves


@pytest.fixture
def scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable("transformables", default_set=True) is not None
    _add_snake()
    _add_box()
    bpy.context.scene.transformables.target_stage.resolution = 24
    bpy.context.view_layer.update()
    yield bpy.context.scene
    addon_utils.disable("transformables", default_set=True)


@pytest.fixture
def stand_in(monkeypatch):
    """A native module that designs nothing but answers at once, where only the plumbing is tested."""
    from transformables.core import job
    monkeypatch.setattr(job, "native_dir", lambda: STAND_IN)


def _add_snake():
    snake = bpy.data.objects.new("Snake", bpy.data.armatures.new("Snake"))
    bpy.context.scene.collection.objects.link(snake)
    bpy.context.view_layer.objects.active = snake
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for i in range(3):
        bone = snake.data.edit_bones.new(f"link{i}")
        bone.head, bone.tail = (0, i, 0), (0, i + 1, 0)
        bone.parent = parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")


def _add_box():
    mesh = bpy.data.meshes.new("Box")
    corners = [(x, y, z) for x in (-1, 1) for y in (-2, 2) for z in (-1, 1)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Box", mesh))


def _roles():
    return sorted(obj["transformable_role"] for obj in bpy.data.objects if "transformable_role" in obj)


def _last():
    from transformables.ui import session
    assert session.current() is None, "the job was not ended"
    return session.last


def test_checking_the_character_tells_its_hinges(scene):
    assert bpy.ops.transformables.check_character() == {"FINISHED"}
    assert scene.transformables.character_stage.stored.splitlines() == ["3 of 3 bones are used", "2 hinges"]


def test_a_character_that_cannot_be_used_is_refused_in_words(scene):
    bpy.data.objects["Snake"].scale = (1, 2, 1)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="scaled unevenly"):
        bpy.ops.transformables.design()
    assert "scaled unevenly" in _last().error
    assert _roles() == []


def test_an_option_that_does_not_fit_is_refused_in_words(scene):
    scene.transformables.target_stage.size_mm = 1
    scene.transformables.finishing_stage.clearance_mm = 5
    with pytest.raises(RuntimeError, match="clearance"):
        bpy.ops.transformables.design()
    assert "clearance" in _last().error


def test_design_makes_the_rig_and_its_parts_and_keeps_pose_and_path(scene):
    assert bpy.ops.transformables.design() == {"FINISHED"}
    roles = _roles()
    assert roles.count("rig") == 1 and roles.count("part") >= 2
    assert _last().error == "" and "parts" in _last().summary
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


def test_a_stored_pose_that_is_out_of_date_is_not_used(scene, stand_in):
    bpy.ops.transformables.embed()
    scene.transformables.embedding_stage.seed = 3
    from transformables.ui import results
    assert results.stored(scene, ("embedding", "path")) == {}


def test_an_error_of_the_worker_is_told_and_leaves_the_scene_alone(scene):
    flat = bpy.data.objects["Box"].data
    for vertex in flat.vertices:
        vertex.co.z = 0
    flat.update()
    before = {obj.name for obj in bpy.data.objects}
    with pytest.raises(RuntimeError, match="volume"):
        bpy.ops.transformables.design()
    assert "volume" in _last().error
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
    assert words in _last().error and "\n" not in _last().error
    assert _roles() == [] and scene.transformables.embedding_stage.stored == ""
    scene.transformables.embedding_stage.seed = 0
    assert bpy.ops.transformables.design() == {"FINISHED"}
    assert _last().error == ""


if __name__ == "__main__":
    sys.stdout.flush()
    code = pytest.main(["-q", "-rs", "-p", "no:cacheprovider", os.path.abspath(__file__)])
    sys.stdout.flush()
    os._exit(int(code))
