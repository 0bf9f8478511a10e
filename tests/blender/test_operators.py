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


def test_exploring_lists_poses_and_using_one_makes_it_the_pose_of_later_stages(scene, stand_in):
    import json
    group = scene.transformables.embedding_stage
    group.explore_count = 3
    assert bpy.ops.transformables.explore() == {"FINISHED"}
    assert len(group.solutions) == 3 and _last().summary.startswith("3 different poses")
    group.solution = 2
    from transformables.ui import overlays
    assert overlays.shown() == 3
    scene.transformables.folding_stage.stored = scene.transformables.folding_stage.stored_for = "of another pose"
    assert bpy.ops.transformables.use_solution() == {"FINISHED"}
    assert json.loads(group.stored)["angles"] == pytest.approx([0.2, 0.2])
    assert scene.transformables.folding_stage.stored == ""
    from transformables.ui import results
    assert results.stored(scene, ("embedding",))["embedding"]["angles"] == pytest.approx([0.2, 0.2])


def test_poses_that_are_kept_stay_when_exploring_again_and_the_others_go(scene, stand_in):
    group = scene.transformables.embedding_stage
    group.explore_count = 3
    bpy.ops.transformables.explore()
    group.solutions[1].kept = True
    kept = group.solutions[1].embedding
    bpy.ops.transformables.explore()
    assert [s.embedding for s in group.solutions].count(kept) >= 1 and len(group.solutions) == 4 and group.solutions[0].embedding == kept
    group.solution = 0
    assert bpy.ops.transformables.delete_solution() == {"FINISHED"}
    assert len(group.solutions) == 3 and not any(s.kept for s in group.solutions)


def test_the_list_of_poses_is_kept_in_the_file(scene, stand_in, tmp_path):
    group = scene.transformables.embedding_stage
    group.explore_count = 2
    bpy.ops.transformables.explore()
    before = [(s.embedding, s.thumbnail, s.score) for s in group.solutions]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "x.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "x.blend"))
    after = bpy.context.scene.transformables.embedding_stage.solutions
    assert [(s.embedding, s.thumbnail, s.score) for s in after] == before


def test_a_terms_bar_is_its_share_of_the_score(scene, stand_in):
    group = scene.transformables.embedding_stage
    bpy.ops.transformables.explore()
    assert group.solutions[0].compact == pytest.approx(40)  # the stand-in says 0.1 of 0.25
    assert group.solutions[0].skin == 0


def test_a_thumbnail_shows_the_targets_shadow_and_the_bones_in_it(scene, stand_in):
    from transformables.ui import thumbnail
    from transformables.bridge import mesh
    box = mesh.read_triangles(bpy.context, bpy.data.objects["Box"])
    picture = thumbnail.pixels_of(thumbnail.draw(*box, [(0, -1.5, 0), (0, 0, 0), (0, 0, 0), (0.5, 1, 0)]))
    assert picture.shape == (64, 64, 4)
    seen, bones = picture[..., 3] > 0, picture[..., 3] == 1
    assert 0.9 ** 2 * 0.45 < seen.mean() < 0.9 ** 2 * 0.55, "a box half as wide as long"
    assert 40 < bones.sum() < 200
    colours = {tuple(c) for c in picture[bones]}
    assert len(colours) == 2, "a colour a bone"


def test_what_is_steered_is_told_to_the_search_and_makes_an_older_pose_out_of_date(scene, stand_in):
    from transformables.bridge import design
    from transformables.ui import fingerprint, steering
    group = scene.transformables.embedding_stage
    bpy.ops.transformables.embed()
    assert bpy.ops.transformables.list_bones() == {"FINISHED"}
    assert [b.name for b in group.bones] == ["link0", "link1", "link2"]
    assert fingerprint.fits(scene, "embedding", group.stored_for)
    group.weights.skeleton = 2
    group.bones["link1"].lock = group.bones["link2"].pin = True
    group.bones["link0"].proportion = "keep"
    told = steering.of(scene)
    pose = told.pop("pose")
    assert told == {"weights": {"skeleton": 2000}, "locked": ["link1"], "pinned": ["link2"], "proportions": {"link0": [1.0, 1.0]}}
    assert pose["angles"] == pytest.approx([0.5, 0.5])
    assert not fingerprint.fits(scene, "embedding", group.stored_for)
    assert bpy.ops.transformables.embed() == {"FINISHED"}
    bpy.ops.transformables.list_bones()
    assert group.bones["link1"].lock, "listing again keeps what was set"


def test_a_pin_without_a_pose_is_refused_in_words(scene, stand_in):
    bpy.ops.transformables.list_bones()
    scene.transformables.embedding_stage.bones["link2"].pin = True
    with pytest.raises(RuntimeError, match="need a folded pose"):
        bpy.ops.transformables.embed()


def test_the_pose_rig_is_a_copy_that_reads_back_as_the_pose_it_was_given(scene, stand_in):
    import json
    from transformables.bridge import guide
    group, snake = scene.transformables.embedding_stage, bpy.data.objects["Snake"]
    bpy.ops.transformables.embed()
    before = [tuple(map(tuple, b.matrix_basis)) for b in snake.pose.bones]
    assert bpy.ops.transformables.pose_guide() == {"FINISHED"}
    rig = guide.of(scene, snake)
    assert rig is not None and bpy.context.mode == "POSE" and rig.pose.use_auto_ik
    read = guide.read(bpy.context, rig)
    wanted = json.loads(group.stored)
    assert read["angles"] == pytest.approx(wanted["angles"], abs=1e-5)
    assert read["root"] == pytest.approx(wanted["root"], abs=1e-5)
    rig.pose.bones["link2"].rotation_euler.x = -0.3
    rig.pose.bones["link0"].location.y += 1
    again = guide.read(bpy.context, rig)
    assert again["angles"] == pytest.approx([0.5, -0.3]) and not again["symmetric"]
    scale = json.loads(group.made_with)["target"]["scale"]
    assert abs(again["root"][13] - wanted["root"][13]) == pytest.approx(scale, rel=1e-4)
    assert [tuple(map(tuple, b.matrix_basis)) for b in snake.pose.bones] == before


def test_continuing_from_the_pose_rig_starts_there_and_takes_the_rig_away(scene, stand_in):
    from transformables.bridge import guide
    snake = bpy.data.objects["Snake"]
    with pytest.raises(RuntimeError, match="There is no pose rig"):
        bpy.ops.transformables.continue_pose(source="guide")
    with pytest.raises(RuntimeError, match="no folded pose to go on from"):
        bpy.ops.transformables.continue_pose(source="stored")
    bpy.ops.transformables.embed()
    bpy.ops.transformables.pose_guide()
    assert bpy.ops.transformables.continue_pose(source="guide") == {"FINISHED"}
    assert guide.of(scene, snake) is None and bpy.data.objects["Snake"] is snake
    assert bpy.ops.transformables.continue_pose(source="stored") == {"FINISHED"}
    bpy.ops.transformables.pose_guide()
    assert bpy.ops.transformables.pose_guide() == {"FINISHED"}
    assert len([o for o in bpy.data.objects if o.get("transformable_role") == "guide"]) == 1


def test_a_pose_rig_for_a_character_that_has_changed_is_refused_in_words(scene, stand_in):
    bpy.ops.transformables.embed()
    bpy.data.objects["Snake"].data.bones["link1"].name = "renamed"
    with pytest.raises(RuntimeError, match="has changed since"):
        bpy.ops.transformables.pose_guide()


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


@pytest.fixture
def blocked(scene, stand_in):
    """A design of the stand-in, in which link0 and link1 were in each other's way."""
    assert bpy.ops.transformables.design() == {"FINISHED"}
    stage = scene.transformables.folding_stage
    assert len(stage.blocks) == 1 and stage.blocks[0].facts()["bones"] == ["link0", "link1"]
    return scene


def test_choosing_a_pair_goes_to_its_moment_selects_its_parts_and_marks_the_place(blocked):
    from mathutils import Vector
    from transformables.ui import block_overlay
    facts = blocked.transformables.folding_stage.blocks[0].facts()
    blocked.transformables.folding_stage.block = 0
    assert blocked.frame_current_final == pytest.approx(facts["frame"], abs=1e-3)
    assert {o["transformable_bone"] for o in bpy.context.selected_objects} == {"link0", "link1"}
    rig = next(o for o in bpy.data.objects if o.get("transformable_role") == "rig")
    wanted = rig.matrix_world @ rig.pose.bones["link0"].matrix @ Vector(facts["place"])
    assert block_overlay.shown() and (block_overlay.place() - wanted).length < 1e-6
    assert bpy.ops.transformables.hide_block() == {"FINISHED"} and not block_overlay.shown()
    assert bpy.ops.transformables.show_block() == {"FINISHED"} and block_overlay.shown()
    bpy.data.objects.remove(rig)
    assert block_overlay.place() is None, "what is drawn may be deleted at any time"
    with pytest.raises(RuntimeError, match="not in the scene any more"):
        bpy.ops.transformables.show_block()


def test_the_ball_at_the_place_has_its_radius():
    from mathutils import Vector
    from transformables.ui import block_overlay
    centre = Vector((1, 2, 3))
    points = block_overlay.circles(centre, 0.5)
    assert all(abs((p - centre).length - 0.5) < 1e-6 for p in points) and len(points) % 2 == 0
    assert all(max(p[a] for p in points) == pytest.approx(centre[a] + 0.5) for a in range(3))


def test_a_pair_is_remedied_by_less_skin_on_one_of_its_parts(blocked):
    assert bpy.ops.transformables.less_skin(which="second") == {"FINISHED"}
    edits = blocked.transformables.segmentation_stage.edits
    assert [(e.kind, e.bone) for e in edits] == [("inhibit", "link1")]


def test_a_pair_is_remedied_by_a_joint_locked_at_another_angle(blocked):
    import json
    s = blocked.transformables
    s.folding_stage.block = 0
    assert s.folding_stage.lock_angle == pytest.approx(0.5), "the folded angle is what one starts from"
    s.folding_stage.lock_angle = -0.25
    angle = int(s.folding_stage.lock_joint)
    told = _told_to_worker(lambda: bpy.ops.transformables.lock_joint())
    assert told["stored"]["start"]["angles"][angle] == pytest.approx(-0.25)
    assert told["steering"]["locked"] == ["link1"] and told["until"] == "finishing"
    assert s.embedding_stage.bones["link1"].lock
    assert json.loads(s.embedding_stage.stored)["angles"]


def test_a_pair_is_remedied_by_another_pose_that_has_to_beat_the_present_one(blocked):
    import json
    group = blocked.transformables.embedding_stage
    pose = json.loads(group.stored)
    told = _told_to_worker(lambda: bpy.ops.transformables.keep_apart())
    assert told["stored"]["rival"]["angles"] == pose["angles"] and told["steering"]["apart"] == [["link0", "link1"]]
    assert told["options"]["seed"] == 1 and group.seed == 1 and len(group.apart) == 1
    assert bpy.ops.transformables.keep_apart() == {"FINISHED"}
    assert group.seed == 2 and len(group.apart) == 1, "a pair is listed once"
    from transformables.ui import fingerprint
    assert fingerprint.fits(blocked, "embedding", group.stored_for)
    assert bpy.ops.transformables.forget_apart(index=0) == {"FINISHED"}
    assert len(group.apart) == 0 and not fingerprint.fits(blocked, "embedding", group.stored_for)


@pytest.mark.parametrize("remedy", ["less_skin", "lock_joint", "keep_apart"])
def test_a_remedy_that_fails_changes_no_setting(blocked, monkeypatch, remedy):
    from transformables.ui.job_operator import JobOperator
    s = blocked.transformables

    def state():
        return (s.embedding_stage.seed, len(s.embedding_stage.apart), [(b.name, b.lock) for b in s.embedding_stage.bones if b.lock],
                len(s.segmentation_stage.edits), s.embedding_stage.stored, len(s.folding_stage.blocks))

    before = state()

    def dies(self, context):
        raise UserError("the worker process ended")

    from transformables.core.options import UserError
    monkeypatch.setattr(JobOperator, "_take_events", dies)
    with pytest.raises(RuntimeError, match="worker process ended"):
        getattr(bpy.ops.transformables, remedy)()
    assert state() == before
    _last()


def _told_to_worker(run):
    """The message that an operator sends to its worker."""
    from transformables.core import job
    sent, real = [], job.Job.__init__

    def init(self, message, arrays, *rest, **more):
        sent.append(message)
        real(self, message, arrays, *rest, **more)

    job.Job.__init__ = init
    try:
        assert run() == {"FINISHED"}
    finally:
        job.Job.__init__ = real
    return sent[0]
