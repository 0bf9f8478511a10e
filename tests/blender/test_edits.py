# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's wishes for the segmentation: the list in the panel, what is read from the target, and what the parts become."""
import json

import bpy
from mathutils import Vector
import numpy as np
import pytest

from jobs import last
from made_wishes import gathered, parts_in_object_mode


def _wish(kind, bone="", group="", **more):
    stage = bpy.context.scene.transformables.segmentation_stage
    assert bpy.ops.transformables.add_edit(kind=kind) == {"FINISHED"}
    edit = stage.edits[stage.active_edit]
    edit.bone, edit.group = bone, group
    for name, value in more.items():
        setattr(edit, name, value)
    return edit


def _paint(obj, name, wanted):
    """A vertex group of the vertices for which wanted(co) holds."""
    group = obj.vertex_groups.new(name=name)
    group.add([v.index for v in obj.data.vertices if wanted(v.co)], 1.0, "REPLACE")
    return group


def test_wishes_are_added_with_what_is_active_and_removed(scene):
    stage = scene.transformables.segmentation_stage
    snake, box = bpy.data.objects["Snake"], bpy.data.objects["Box"]
    snake.data.bones.active = snake.data.bones["link1"]
    _paint(box, "lid", lambda co: co.z > 0)
    for kind in ("inhibit", "remove", "keep_whole", "assign"):
        bpy.ops.transformables.add_edit(kind=kind)
    assert [(e.kind, e.bone, e.group) for e in stage.edits] == [
        ("inhibit", "link1", ""), ("remove", "link1", ""), ("keep_whole", "", "lid"), ("assign", "link1", "lid")]
    stage.active_edit = 1
    bpy.ops.transformables.remove_edit()
    assert [e.kind for e in stage.edits] == ["inhibit", "keep_whole", "assign"] and stage.active_edit == 1
    for _ in range(3):
        bpy.ops.transformables.remove_edit()
    assert len(stage.edits) == 0 and not bpy.ops.transformables.remove_edit.poll()


def test_a_wish_is_undone_and_kept_in_the_file(scene, tmp_path):
    bpy.ops.ed.undo_push(message="before")
    _wish("remove", "link1")
    bpy.ops.ed.undo_push(message="a wish")
    bpy.ops.ed.undo()
    assert len(bpy.context.scene.transformables.segmentation_stage.edits) == 0
    bpy.ops.ed.redo()
    edit, = bpy.context.scene.transformables.segmentation_stage.edits
    assert (edit.kind, edit.bone) == ("remove", "link1")
    path = str(tmp_path / "wish.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    edit, = bpy.context.scene.transformables.segmentation_stage.edits
    assert (edit.kind, edit.bone) == ("remove", "link1")


def test_painted_faces_are_read_as_the_target_shows_with_modifiers_and_place(scene):
    box = bpy.data.objects["Box"]
    _paint(box, "lid", lambda co: co.z > 0)
    box.location, box.scale = (5, 6, 7), (2, 2, 2)
    modifier = box.modifiers.new("finer", "SUBSURF")
    modifier.subdivision_type, modifier.levels = "SIMPLE", 2
    _wish("keep_whole", group="lid")
    rows, arrays = gathered()
    corners = np.frombuffer(arrays[rows[0]["faces"]][1]).reshape(-1, 3, 3)
    assert rows[0]["name"] == "lid" and len(corners) >= 32  # 4 x 4 faces of two triangles
    top = corners[np.isclose(corners[:, :, 2], 9).all(axis=1)]
    sides = np.linalg.norm(np.cross(top[:, 1] - top[:, 0], top[:, 2] - top[:, 0]), axis=1) / 2
    assert sides.sum() == pytest.approx(4 * 8)
    assert corners[:, :, 2].min() > 7 - 1e-5  # never the lower half


def test_a_group_that_is_gone_gives_no_faces_and_an_empty_choice_is_refused_in_words(scene):
    _wish("keep_whole", group="nothing")
    rows, arrays = gathered()
    assert arrays[rows[0]["faces"]][1] == b""
    _wish("assign", bone="", group="nothing")
    with pytest.raises(RuntimeError, match="names no bone"):
        bpy.ops.transformables.segment()
    assert "names no bone" in last().error


def test_a_wish_that_is_switched_off_is_not_sent(scene):
    _wish("remove", "link1", enabled=False)
    assert gathered() == ([], {})


def test_how_joints_get_their_room_is_chosen_for_all_or_for_one(scene, stand_in):
    from transformables.ui import fingerprint, job_operator
    _wish("bone_gives", "link1")
    _wish("parent_gives", "link2")
    assert gathered() == ([{"kind": "bone_gives", "bone": "link1"}, {"kind": "parent_gives", "bone": "link2"}], {})
    bpy.ops.transformables.segment()
    stage = scene.transformables.segmentation_stage
    assert fingerprint.fits(scene, "segmentation", stage.stored_for, thorough=True)
    for way in ("cylinder", "exact"):
        stage.transfer = way
        assert job_operator.options_of(scene).transfer == way
    assert not fingerprint.fits(scene, "segmentation", stage.stored_for, thorough=True)


def test_wishes_and_what_is_painted_make_stored_parts_out_of_date(scene, stand_in):
    from transformables.ui import fingerprint
    box = bpy.data.objects["Box"]
    group = _paint(box, "lid", lambda co: co.z > 0)
    bpy.ops.transformables.segment()
    stage = scene.transformables.segmentation_stage

    def fits():
        return fingerprint.fits(scene, "segmentation", stage.stored_for, thorough=True)
    assert fits()
    _wish("keep_whole", group="lid")
    assert not fits()
    bpy.ops.transformables.segment()
    assert fits()
    group.remove([box.data.vertices[0].index, box.data.vertices[1].index])
    assert not fits()
    stage.edits[0].enabled = False
    bpy.ops.transformables.segment()
    assert fits()
    pose = scene.transformables.embedding_stage
    assert fingerprint.fits(scene, "embedding", pose.stored_for, thorough=True), "the folded pose does not depend on wishes"


def _shares():
    return json.loads(bpy.context.scene.transformables.segmentation_stage.stored)


def test_parts_become_as_wished_and_what_makes_no_sense_is_told(scene):
    bpy.ops.transformables.embed()
    bpy.ops.transformables.segment()
    before = _shares()
    assert len(before) == 3
    victim = min(before, key=before.get)
    _wish("inhibit", victim)
    bpy.ops.transformables.segment()
    assert _shares()[victim] < 0.7 * before[victim]
    assert sum(_shares().values()) == pytest.approx(sum(before.values()), abs=0.03)
    scene.transformables.segmentation_stage.edits[0].kind = "remove"
    _wish("remove", "somebody else")
    bpy.ops.transformables.segment()
    assert _shares().get(victim, 0) < 0.7 * before[victim]
    assert any("'somebody else'" in text for text in last().warnings)


def test_a_finished_design_holds_what_was_wished(scene):
    """The box's painted end is of the named bone, and a bone without skin is bare: when the target is divided, in a pose that was found before anything
    was painted; and after a new search, folding, carving and the proof."""
    box = bpy.data.objects["Box"]
    modifier = box.modifiers.new("finer", "SUBSURF")
    modifier.subdivision_type, modifier.levels = "SIMPLE", 3
    _paint(box, "end", lambda co: co.y > 0)
    bpy.ops.transformables.embed()
    bpy.ops.transformables.segment()
    before, shares = _owners_at_end(box), _shares()
    holder = max(before, key=before.get)
    named, bare = sorted((name for name in shares if name != holder), key=lambda name: before.get(name, 0))
    assert before.get(named, 0) < 0.5 * sum(before.values())
    _wish("assign", named, "end")
    _wish("remove", bare)
    bpy.ops.transformables.segment()
    divided = _owners_at_end(box)
    assert divided[named] >= 0.95 * sum(divided.values())
    assert _shares().get(bare, 0) < 0.5 * shares[bare]
    bpy.ops.transformables.embed()
    assert bpy.ops.transformables.finish() == {"FINISHED"}
    after = _owners_at_end(box)
    assert after[named] >= 0.95 * sum(after.values())
    assert _shares().get(bare, 0) < 0.5 * shares[bare]
    assert not [told for told in last().warnings if not told.startswith("No pin")]   # pins are no matter of wishes


def test_a_new_search_brings_the_named_bone_to_what_is_painted(scene):
    box = bpy.data.objects["Box"]
    _paint(box, "end", lambda co: co.y > 0)
    bpy.ops.transformables.embed()
    bpy.ops.transformables.segment()
    before = _owners_at_end(box)
    named = min(_shares(), key=lambda name: before.get(name, 0))
    wish = _wish("assign", named, "end")
    bpy.ops.transformables.embed()
    wish.enabled = False  # to see what the pose alone does
    bpy.ops.transformables.segment()
    after = _owners_at_end(box)
    assert before.get(named, 0) < 0.3 * sum(before.values()) and after.get(named, 0) >= 0.75 * sum(after.values())


def _owners_at_end(box):
    """How many of the points spread over the painted end show each part: rays along Y, asked of the parts in object mode."""
    trees, found = parts_in_object_mode(), {}
    for x in np.linspace(-0.9, 0.9, 12):
        for z in np.linspace(-0.9, 0.9, 12):
            hits = {name: tree.ray_cast(box.matrix_world @ Vector((x, 3, z)), Vector((0, -1, 0))) for name, tree in trees.items()}
            near = {name: hit[3] for name, hit in hits.items() if hit[0] is not None}
            name = min(near, key=near.get) if near else None
            found[name] = found.get(name, 0) + 1
    return found
