# SPDX-License-Identifier: GPL-3.0-or-later
"""Results in Blender, from numbers made by hand: rig, parts, inputs. What they promise is CONTRACT.md's."""
import bpy
from mathutils import Euler, Matrix, Vector
import numpy as np
import pytest
import scenes
from hand_made import BOX, BOX_FACES, FIT, ROOT, UNITS, at, hand_made, made, samples, scene, world_of_bones  # scene and made are fixtures
from transformables.bridge import design
from transformables.core import kinematics
from transformables.core.options import DesignOptions


def test_objects_carry_the_contracts_marks(made):
    rig, bones = made["rig"], {"trunk", "thigh.L", "shin.L", "thigh.R", "shin.R", "head"}
    assert made["character"]["transformable_role"] == "character" and made["target"]["transformable_role"] == "target"
    assert rig["transformable_role"] == "rig" and rig["transformable_source"] == "walker"
    parts = [o for o in bpy.data.objects if o.get("transformable_role") == "part"]
    assert {p["transformable_bone"] for p in parts} == bones  # feet are one body with their shins
    assert made["target"].hide_viewport and made["target"].hide_render
    assert not made["character"].hide_viewport


def test_the_rig_has_the_characters_names_hierarchy_and_rest_angles_and_the_designs_lengths(made):
    rig, source, factors = made["rig"].data, made["character"].data, made["result"]["embedding"]["morphology"]
    assert set(rig.bones.keys()) == set(source.bones.keys())
    body_of = {made["result"]["character"]["names"][m]: i for i, ms in enumerate(made["result"]["character"]["members"]) for m in ms}
    for bone in rig.bones:
        old = source.bones[bone.name]
        assert (bone.parent.name if bone.parent else None) == (old.parent.name if old.parent else None)
        assert scenes.close(bone.matrix_local.to_3x3().to_4x4(), old.matrix_local.to_3x3().to_4x4())
        factor = 2.0 * FIT / UNITS * factors[body_of[bone.name]]  # the object's scale of 2 counts
        assert bone.length == pytest.approx(old.length * factor, rel=1e-4)
    assert made["rig"].matrix_world.to_scale()[:] == pytest.approx((1, 1, 1))


def test_character_mode_is_the_rest_pose_standing_where_the_target_stands(made):
    depsgraph = at(1)
    rig = made["rig"].evaluated_get(depsgraph)
    assert all(scenes.close(b.matrix_basis, Matrix()) for b in rig.pose.bones)
    corners = [p.evaluated_get(depsgraph).matrix_world @ v.co for p in made["parts"] for v in p.data.vertices]
    assert min(c.z for c in corners) == pytest.approx(5.0, abs=1e-4)  # the box stands from 5 to 7
    head = rig.matrix_world @ rig.pose.bones["trunk"].head
    assert head[:2] == pytest.approx((4, 5), abs=1e-4)


def test_object_mode_is_the_folded_pose_at_the_targets_place(made):
    result = made["result"]
    root = Matrix(ROOT)
    root.translation = root.translation / UNITS + Vector((4, 5, 6))
    bones = world_of_bones(made["rig"], made["schedule"].last_frame)
    assert scenes.close(bones["trunk"], root, 1e-4)
    flat = [np.frombuffer(made["arrays"][n][1], np.float64).tolist() for n in ("heads", "tails", "axes")]
    character = result["character"]
    skeleton = kinematics.Skeleton(character["members"], character["body_parents"], character["hinges"], character["first_angle"], *flat)
    rotation = tuple(tuple(row) for row in root.to_3x3())
    frames = skeleton.frames(rotation, tuple(root.translation), result["embedding"]["angles"], result["embedding"]["morphology"], FIT / UNITS)
    for name, (turn, head) in zip(character["bodies"], frames):
        wanted = Matrix(turn).to_4x4()
        wanted.translation = head
        assert scenes.close(bones[name], wanted, 1e-4), name


def test_every_part_moves_rigidly_with_its_bone(made):
    for frame in samples(made, 7.3):
        depsgraph = at(frame)
        rig = made["rig"].evaluated_get(depsgraph)
        for part in made["parts"]:
            world = part.evaluated_get(depsgraph).matrix_world
            assert scenes.close(world, rig.matrix_world @ rig.pose.bones[part["transformable_bone"]].matrix, 1e-4)
            assert world.to_scale()[:] == pytest.approx((1, 1, 1), abs=1e-5)


def relative(made, bone, frame):
    """The bone's turn against its rest, as its parent sees it, and its head in the parent's frame."""
    pose = made["rig"].evaluated_get(at(frame)).pose.bones
    rest = bone.parent.matrix_local.inverted() @ bone.matrix_local
    now = pose[bone.parent.name].matrix.inverted() @ pose[bone.name].matrix
    return rest.to_3x3().inverted() @ now.to_3x3(), now.translation


def test_joints_turn_about_their_own_axes_inside_their_limits_and_heads_stay_in_place(made):
    hinges = dict(zip(made["result"]["character"]["bodies"], made["result"]["character"]["hinges"]))
    size = max(made["rig"].dimensions)
    for bone in made["rig"].data.bones:
        if bone.parent is None:
            continue
        rest_head = (bone.parent.matrix_local.inverted() @ bone.matrix_local).translation
        for frame in samples(made, 3.7):
            turn, head = relative(made, bone, frame)
            assert (head - rest_head).length < 1e-5 * size
            angles = Matrix(turn).to_euler("XYZ")
            for axis in range(3):
                limits = next(((a, b) for hinge, a, b in hinges.get(bone.name, []) if hinge == axis), (0, 0))
                assert limits[0] - 2e-3 <= angles[axis] <= limits[1] + 2e-3, (bone.name, frame)


def test_parts_are_the_numbers_that_came_in(made):
    for part in made["parts"]:
        mesh = part.data
        corners = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", corners)
        assert corners.reshape(-1, 3) == pytest.approx(BOX / UNITS, abs=1e-6)
        assert [tuple(p.vertices) for p in mesh.polygons] == [tuple(t) for t in BOX_FACES]
        assert not mesh.validate()  # True: Blender had to correct it


def test_inputs_are_untouched_but_for_their_marks(scene):
    character, target = scene

    def state():
        return ([(b.name, tuple(b.head_local), tuple(b.tail_local), b.parent.name if b.parent else "") for b in character.data.bones],
                [tuple(b.matrix_basis.to_quaternion()) for b in character.pose.bones], tuple(map(tuple, character.matrix_world)),
                [tuple(v.co) for v in target.data.vertices], tuple(map(tuple, target.matrix_world)), character.animation_data)

    before = state()
    options = DesignOptions()
    design.apply(bpy.context, *hand_made(character, target, options), character, target, options)
    at(50)
    assert state() == before


def test_running_again_replaces_the_older_result_and_leaves_nothing_behind(made):
    counts = [len(c) for c in (bpy.data.objects, bpy.data.meshes, bpy.data.armatures, bpy.data.actions, bpy.data.collections)]
    kept = bpy.data.objects.new("mine", None)
    made["collection"].objects.link(kept)
    options = DesignOptions()
    again = design.apply(bpy.context, made["result"], made["arrays"], made["character"], made["target"], options)
    assert again["collection"] == made["collection"] and kept.name in again["collection"].objects
    bpy.data.objects.remove(kept)
    assert [len(c) for c in (bpy.data.objects, bpy.data.meshes, bpy.data.armatures, bpy.data.actions, bpy.data.collections)] == counts


def test_a_hidden_target_of_an_earlier_design_is_read_with_its_modifiers(made):
    target = made["target"]
    target.modifiers.new("more", "SUBSURF").subdivision_type = "SIMPLE"
    _, arrays = design.gather(made["character"], target, DesignOptions())
    assert len(arrays["triangles"][1]) // 12 == 48
    assert target.hide_viewport


def test_a_mirrored_target_keeps_its_outside_out(empty_scene):
    character = scenes.walker()
    for scale in ((1, 1, 1), (-1, 1, 1), (-2, -1, -3)):
        target = scenes.placed(scenes.cube("box", 1.0), scale=scale, rotation=(10, 20, 30))
        _, arrays = design.gather(character, target, DesignOptions())
        vertices = np.frombuffer(arrays["vertices"][1]).reshape(-1, 3)
        corners = vertices[np.frombuffer(arrays["triangles"][1], np.int32).reshape(-1, 3)]
        volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        assert volume == pytest.approx(abs(np.prod(scale)), rel=1e-5)
        bpy.data.objects.remove(target)


def test_a_result_without_parts_shows_the_rig_alone(scene):
    options = DesignOptions()
    result, arrays = hand_made(*scene, options)
    result.update(until="embedding", path=None, finishing=None)
    made = design.apply(bpy.context, result, arrays, *scene, options)
    assert made["parts"] == [] and made["report"]["certified"] is False
    assert made["schedule"].angles_at(made["schedule"].last_frame, result["character"]["angle_count"]) == pytest.approx(result["embedding"]["angles"])


def test_euler_angles_mean_the_same_here_and_in_the_native_module():
    hinges = [(0, -1, 1), (1, -1, 1), (2, -1, 1)]
    turn = kinematics.joint_rotation(hinges, (0.3, -0.7, 1.1))
    assert scenes.close(Matrix(turn).to_4x4(), Euler((0.3, -0.7, 1.1), "XYZ").to_matrix().to_4x4(), 1e-6)
