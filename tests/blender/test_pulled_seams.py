# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams and the division of the surface, as they are stored with the parts, and seams that are pulled."""
import json

import bpy
from mathutils import Vector
import numpy as np
import pytest

from transformables.bridge import division
from jobs import last
from made_wishes import gathered, parts_in_object_mode


def _stored_seams():
    return json.loads(bpy.context.scene.transformables.segmentation_stage.seams)


def _division():
    return division.read(bpy.context.scene.transformables.segmentation_stage.division)[2]


def _pull(seam_index, by, size=0.0):
    """Pulls a seam's topmost point along Y. Gives that point."""
    points = _stored_seams()[seam_index]["points"]
    top = max(range(len(points)), key=lambda i: points[i][2])
    assert bpy.ops.transformables.move_seam(seam=seam_index, point=top, displacement=(0, by, 0), size=size) == {"FINISHED"}
    return points[top]


def _nearest(seams, bones, point):
    return min(np.linalg.norm(np.array(seam["points"]) - point, axis=1).min() for seam in seams if seam["bones"] == bones)


def test_dividing_the_target_stores_its_seams_in_the_targets_own_space(scene):
    box = bpy.data.objects["Box"]
    box.location, box.rotation_euler, box.scale = (3, 4, 5), (0.3, 0.5, 0.7), (2, 2, 2)
    bpy.ops.transformables.embed()
    assert not bpy.ops.transformables.move_seam.poll()
    bpy.ops.transformables.segment()
    seams = _stored_seams()
    assert seams
    for seam in seams:
        off = np.abs(np.array(seam["points"])) / (1, 2, 1)  # the box's half sides
        assert np.abs(off.max(axis=1) - 1).max() < 0.1, "on the surface"


def test_dividing_the_target_stores_whose_each_place_of_its_surface_is(scene):
    box, stage = bpy.data.objects["Box"], scene.transformables.segmentation_stage
    box.location, box.rotation_euler, box.scale = (3, 4, 5), (0.3, 0.5, 0.7), (-2, 2, 2)
    bpy.ops.transformables.embed()
    bpy.ops.transformables.segment()
    vertices, triangles, parts = division.read(stage.division)
    assert np.abs(np.abs(vertices) / (1, 2, 1)).max(axis=1) == pytest.approx(1, abs=1e-4), "on the surface, in the box's own space"
    corners = vertices[triangles]
    six = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    assert six / 6 == pytest.approx(16, rel=1e-3), "outward"
    trees = parts_in_object_mode()
    names = {division.body(stage.division, name): name for name in trees}  # a bone a body here
    some = np.linspace(0, len(vertices) - 1, 300).astype(int)
    right = [min(trees, key=lambda name: trees[name].find_nearest(box.matrix_world @ Vector(vertices[i]))[3]) == names[parts[i]] for i in some]
    assert np.mean(right) > 0.97
    older = stage.division.name
    bpy.ops.transformables.segment()
    assert [m.name for m in bpy.data.meshes if division.BODIES in m] == [stage.division.name] and stage.division.name.startswith("Box"), older


def test_a_pulled_seam_is_a_wish_that_the_next_division_heeds(scene):
    bpy.ops.transformables.embed()
    bpy.ops.transformables.segment()
    before, parts = _stored_seams(), _division()
    voxel = 4 / 24
    # The longest seam runs along a side of the box; it is pulled up there.
    index = max(range(len(before)), key=lambda i: len(before[i]["points"]))
    bones, points = before[index]["bones"], np.array(before[index]["points"])
    pulled = min(np.flatnonzero(np.abs(points[:, 0]) > 0.99), key=lambda i: abs(points[i, 1]))
    there = points[pulled] + (0, 0, 3 * voxel)
    assert bpy.ops.transformables.move_seam(seam=index, point=int(pulled), displacement=(0, 0, 3 * voxel), size=0.0) == {"FINISHED"}
    dragged = _division()
    edit, = scene.transformables.segmentation_stage.edits
    assert edit.kind == "move_seam" and [edit.bone, edit.other] == bones
    assert _nearest(_stored_seams(), bones, there) < 0.2 * voxel, "it is shown where it was pulled to"
    bpy.ops.transformables.segment()
    assert not last().warnings
    changed = parts != dragged
    assert changed.sum() > 20 and (dragged == _division())[changed].mean() > 0.85, "the parts came out as they were shown"
    assert _nearest(_stored_seams(), bones, there) < voxel
    assert _nearest(before, bones, there) > 1.5 * voxel
    assert bpy.ops.transformables.plan_fold() == {"FINISHED"}
    place = bpy.data.objects["Box"].matrix_world @ Vector(there)
    trees = parts_in_object_mode()
    for bone in bones:
        assert trees[bone].find_nearest(place)[3] < 1.5 * voxel, "folding left it there; carving may take what can't pass"
    assert bpy.ops.transformables.finish() == {"FINISHED"}


def test_a_seam_without_a_place_is_refused_in_words(scene):
    edit = scene.transformables.segmentation_stage.edits.add()
    edit.kind, edit.bone, edit.other = "move_seam", "link0", "link1"
    with pytest.raises(RuntimeError, match="drag the seam"):
        bpy.ops.transformables.segment()


def test_a_pull_of_nothing_and_one_of_a_point_that_is_not_there_change_nothing(scene, stand_in):
    bpy.ops.transformables.segment()
    assert bpy.ops.transformables.move_seam(seam=0, point=0, displacement=(0, 0, 0)) == {"CANCELLED"}
    with pytest.raises(RuntimeError, match="no point 7000"):
        bpy.ops.transformables.move_seam(seam=0, point=7000, displacement=(0, 1, 0))
    assert len(scene.transformables.segmentation_stage.edits) == 0


def test_a_pulled_seam_follows_the_target_and_stays_on_it(scene, stand_in):
    bpy.ops.transformables.segment()
    box = bpy.data.objects["Box"]
    box.scale = (3, 3, 3)
    bpy.context.view_layer.update()
    _pull(0, 0.2)
    rows, arrays = gathered()
    points = np.frombuffer(arrays[rows[0]["to"]][1]).reshape(-1, 3)
    assert len(points) == len(np.frombuffer(arrays[rows[0]["from"]][1]).reshape(-1, 3)) > 5
    assert np.abs((np.abs(points) / (3, 6, 3)).max(axis=1) - 1).max() < 1e-4
