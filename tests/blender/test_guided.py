# SPDX-License-Identifier: GPL-3.0-or-later
"""A guided example of the paper's kind, scripted: a human folds into a bunny with his head in the bunny's head. With a real worker."""
import json
import os

import bpy
import addon_utils
from mathutils import Matrix, Vector
import pytest

EXAMPLE = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "blend_examples", "bunny_human.blend")
IN_THE_BUNNYS_HEAD = Vector((0.0, -0.25, 0.78))   # where the neck is to end
TO_THE_SNOUT = Vector((0.0, -1.0, 0.2))


@pytest.fixture
def scene():
    bpy.ops.wm.open_mainfile(filepath=EXAMPLE)
    assert addon_utils.enable("transformables", default_set=True) is not None
    bpy.context.scene.transformables.target_stage.resolution = 32
    yield bpy.context.scene
    addon_utils.disable("transformables", default_set=True)


def _head_of(embedding, made):
    """Both ends of the head bone, world space."""
    order = [bone for members in made["character"]["members"] for bone in members]
    at = order.index(made["character"]["names"].index("head"))
    return [Vector(p) for p in embedding["points"][2 * at:2 * at + 2]]


def test_the_head_stays_in_the_bunnys_head_while_the_rest_of_the_body_is_found(scene):
    from transformables.bridge import guide
    group, human = scene.transformables.embedding_stage, bpy.data.objects["human"]
    bpy.ops.transformables.embed()
    bpy.ops.transformables.pose_guide()
    rig = guide.of(scene, human)
    bpy.ops.object.mode_set(mode="OBJECT")
    _move_so_that_the_head_is_in_place(rig)
    bpy.ops.transformables.list_bones()
    group.bones["head"].pin = True
    assert bpy.ops.transformables.embed() == {"FINISHED"}
    embedding, made = json.loads(group.stored), json.loads(group.made_with)
    neck, crown = _head_of(embedding, made)
    assert (neck - IN_THE_BUNNYS_HEAD).length < 1e-3
    assert (crown - neck).normalized().dot(TO_THE_SNOUT.normalized()) > 0.999
    step = 0.5 / 32
    assert embedding["deepest_protrusion"] < step, "the rest of the body was found a place inside"
    bpy.data.objects.remove(rig)
    assert bpy.ops.transformables.continue_pose(source="stored") == {"FINISHED"}
    further = json.loads(group.stored)
    assert (_head_of(further, made)[0] - IN_THE_BUNNYS_HEAD).length < 1e-3
    assert further["value"] <= embedding["value"]


def _move_so_that_the_head_is_in_place(rig):
    bpy.context.view_layer.update()
    now = rig.matrix_world @ rig.pose.bones["head"].matrix
    turn = now.to_3x3().col[1].rotation_difference(TO_THE_SNOUT).to_matrix().to_4x4()
    there = Matrix.Translation(IN_THE_BUNNYS_HEAD) @ turn @ Matrix.Translation(-now.to_translation())
    rig.matrix_world = there @ rig.matrix_world
    bpy.context.view_layer.update()
