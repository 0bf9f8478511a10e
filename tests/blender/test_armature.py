# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters as read from armatures, by the contract's joint rules."""
import math

import pytest
import scenes
from transformables.bridge.armature import hinges_of, read_character
from transformables.core.options import UserError


@pytest.fixture
def joint(empty_scene):
    """A pose bone with nothing set; its armature has a root above it."""
    obj = scenes.armature([("root", None, (0, 0, 0), (0, 0, 1), 0, None), ("arm", "root", (0, 0, 1), (0, 0, 2), 0, None)])
    return obj.pose.bones["arm"]


def read(pose_bone):
    """Hinges in whole degrees."""
    return [(axis, round(math.degrees(a)), round(math.degrees(b))) for axis, a, b in hinges_of(pose_bone, [])[0]]


def lock(pose_bone, letters):
    for letter in letters:
        setattr(pose_bone, f"lock_ik_{letter}", True)


def limit_ik(pose_bone, letter, least, largest):
    setattr(pose_bone, f"use_ik_limit_{letter}", True)
    setattr(pose_bone, f"ik_min_{letter}", math.radians(least))
    setattr(pose_bone, f"ik_max_{letter}", math.radians(largest))


def test_rule_1_every_axis_of_a_local_limit_rotation_with_a_range_is_a_hinge(joint):
    scenes.limit_rotation(joint, x=(0, 0), y=(-30, 45), z=(-10, 0))
    assert read(joint) == [(1, -30, 45), (2, -10, 0)]


def test_rule_1_goes_before_ik_settings(joint):
    lock(joint, "xyz")
    scenes.limit_rotation(joint, x=(-20, 20), y=(0, 0), z=(0, 0))
    assert read(joint) == [(0, -20, 20)]


def test_rule_1_does_not_count_muted_or_world_space_constraints(joint):
    scenes.limit_rotation(joint, x=(0, 0), y=(-30, 30), z=(0, 0)).mute = True
    scenes.limit_rotation(joint, space="WORLD", x=(0, 0), y=(0, 0), z=(-30, 30))
    scenes.limit_rotation(joint, x=(0, 0), y=(-30, 30), z=(0, 0)).influence = 0
    assert read(joint) == [(0, -90, 90)]


def test_a_limit_rotation_in_another_space_is_told_and_not_read(joint):
    scenes.limit_rotation(joint, space="POSE", x=(0, 0), y=(0, 0), z=(-30, 30))
    warnings = []
    assert len(hinges_of(joint, warnings)[0]) == 1
    assert len(warnings) == 1 and "Local Space" in warnings[0] and joint.name in warnings[0]


def test_rule_1_axes_without_a_limit_are_free_like_those_of_ik(joint):
    scenes.limit_rotation(joint, x=(-20, 20), z=(0, 0))
    assert read(joint) == [(0, -20, 20), (1, -90, 90)]


def test_rule_1_several_constraints_hold_together(joint):
    scenes.limit_rotation(joint, x=(-60, 20), y=(0, 0), z=(0, 0))
    scenes.limit_rotation(joint, x=(-30, 50))
    assert read(joint) == [(0, -30, 20)]


def test_rule_2_axes_that_ik_leaves_free_are_hinges_with_its_limits_or_a_right_angle_each_way(joint):
    lock(joint, "y")
    limit_ik(joint, "z", -15, 75)
    assert read(joint) == [(0, -90, 90), (2, -15, 75)]


def test_rule_2_a_limit_alone_speaks_for_the_bone(joint):
    limit_ik(joint, "x", -15, 75)
    assert read(joint) == [(0, -15, 75), (1, -90, 90), (2, -90, 90)]


def test_rule_3_a_silent_bone_turns_about_its_local_x(joint):
    assert read(joint) == [(0, -90, 90)]


def test_rule_4_a_bone_with_every_axis_locked_has_no_hinge(joint):
    lock(joint, "xyz")
    assert read(joint) == []


def test_a_limit_rotation_that_locks_all_axes_fixes_the_bone(joint):
    scenes.limit_rotation(joint, x=(0, 0), y=(0, 0), z=(0, 0))
    assert read(joint) == []


def test_a_range_that_leaves_rest_out_is_widened_to_it_and_told(joint):
    scenes.limit_rotation(joint, x=(20, 60), y=(0, 0), z=(-50, -10))
    warnings = []
    hinges, _ = hinges_of(joint, warnings)
    assert [(a, round(math.degrees(b)), round(math.degrees(c))) for a, b, c in hinges] == [(0, 0, 60), (2, -50, 0)]
    assert len(warnings) == 2 and all("arm" in w for w in warnings)


def test_bones_come_in_world_coordinates_with_their_rest_axes(empty_scene):
    obj = scenes.placed(scenes.walker(), rotation=(20, 30, 40), location=(5, 6, 7), scale=(3, 3, 3))
    obj.pose.bones["head"].rotation_euler = (1, 0, 0)  # a pose is not the rest
    character = read_character(obj)
    for i, name in enumerate(character.names):
        bone = obj.data.bones[name]
        head = obj.matrix_world @ bone.head_local
        assert list(character.heads[3 * i:3 * i + 3]) == pytest.approx(list(head), abs=1e-5)
        wanted = obj.matrix_world.to_quaternion().to_matrix() @ bone.matrix_local.to_3x3()
        assert list(character.axes[9 * i:9 * i + 9]) == pytest.approx([x for row in wanted for x in row], abs=1e-5)
        parent = bone.parent.name if bone.parent else None
        assert (character.names[character.parents[i]] if character.parents[i] >= 0 else None) == parent
        assert character.parents[i] < i
    assert character.hinges[character.names.index("foot.L")] == []
    assert character.hinges[0] == []


@pytest.mark.parametrize("scale, words", [((1, 2, 1), "unevenly"), ((1, 1, 0), "zero"), ((-1, -1, -1), "negative"), ((-1, 1, 1), "negative")])
def test_a_scale_that_is_not_one_positive_number_is_refused(empty_scene, scale, words):
    obj = scenes.placed(scenes.walker(), scale=scale)
    with pytest.raises(UserError, match=words):
        read_character(obj)


def test_of_several_roots_the_character_is_one_tree_and_the_rest_is_told(empty_scene):
    rows = [("pole", None, (5, 0, 0), (5, 0, 0.1), 0, None), ("a", None, (0, 0, 0), (0, 0, 1), 0, None),
            ("b", "a", (0, 0, 1), (0, 0, 2), 0, None), ("c", "b", (0, 0, 2), (0, 0, 3), 0, None)]
    character = read_character(scenes.armature(rows))
    assert character.names == ["a", "b", "c"]
    assert any("pole" in w for w in character.warnings)


def test_bones_that_are_not_joined_are_told_of_where_too_few_are_left(empty_scene):
    rows = [(name, None, (x, 0, 0), (x, 0, 1), 0, None) for x, name in enumerate("abc")]
    with pytest.raises(UserError, match="3 bones, but not joined"):
        read_character(scenes.armature(rows))


def test_an_armature_without_bones_or_with_one_is_refused(empty_scene):
    with pytest.raises(UserError, match="no bones"):
        read_character(scenes.armature([], "bare"))
    with pytest.raises(UserError, match="at least two"):
        read_character(scenes.armature([("a", None, (0, 0, 0), (0, 0, 1), 0, None)], "single"))


def test_simplify_keeps_names_hinges_and_axes_of_what_it_keeps(empty_scene):
    rows = [("root", None, (0, 0, 0), (0, 0, 0.1), 0, None)]
    rows += [(f"seg{i}", f"seg{i - 1}" if i else "root", (0, 0.01 * i, 0.1 + 0.1 * i), (0, 0.01 * (i + 1), 0.2 + 0.1 * i), 5 * i, None)
             for i in range(40)]
    obj = scenes.armature(rows, "worm")
    whole, fewer = read_character(obj), read_character(obj, 12)
    assert len(whole.names) == 41 and 2 <= len(fewer.names) <= 12
    assert fewer.names[0] == "root" and set(fewer.names) < set(whole.names)
    assert sorted(fewer.names + fewer.left_out) == sorted(whole.names)
    for i, name in enumerate(fewer.names):
        j = whole.names.index(name)
        assert fewer.hinges[i] == whole.hinges[j]
        assert fewer.axes[9 * i:9 * i + 9] == whole.axes[9 * j:9 * j + 9]
    assert any("Simplify" in w for w in fewer.warnings)
