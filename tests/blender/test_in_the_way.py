# SPDX-License-Identifier: GPL-3.0-or-later
"""What is in a fold's way, and its remedies: the panel's operators called by a script."""
import bpy
import pytest
from jobs import last, told_to_worker


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
    told = told_to_worker(lambda: bpy.ops.transformables.lock_joint())
    assert told["stored"]["start"]["angles"][angle] == pytest.approx(-0.25)
    assert told["steering"]["locked"] == ["link1"] and told["until"] == "finishing"
    assert s.embedding_stage.bones["link1"].lock
    assert json.loads(s.embedding_stage.stored)["angles"]


def test_a_pair_is_remedied_by_another_pose_that_has_to_beat_the_present_one(blocked):
    import json
    group = blocked.transformables.embedding_stage
    pose = json.loads(group.stored)
    told = told_to_worker(lambda: bpy.ops.transformables.keep_apart())
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
    last()
