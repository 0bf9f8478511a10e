# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses to choose from, to steer and to set by hand: the panel's operators called by a script."""
import bpy
import pytest
from jobs import last


def test_exploring_lists_poses_and_using_one_makes_it_the_pose_of_later_stages(scene, stand_in):
    import json
    group = scene.transformables.embedding_stage
    group.explore_count = 3
    assert bpy.ops.transformables.explore() == {"FINISHED"}
    assert len(group.solutions) == 3 and last().summary.startswith("3 different poses")
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
