# SPDX-License-Identifier: GPL-3.0-or-later
"""The fold in Blender, of a result made by hand: action, markers, loop, pace, slider."""
import bpy
import pytest
import scenes
from hand_made import at, made, samples, scene, world_of_bones  # scene and made are fixtures
from transformables.bridge import animation, design
from transformables.core import schedule
from transformables.core.options import DesignOptions


def test_between_frames_angles_are_those_of_the_schedule(made):
    character = made["result"]["character"]
    for frame in samples(made, 4.37):
        wanted = made["schedule"].angles_at(frame, character["angle_count"])
        for name, first, hinges in zip(character["bodies"], character["first_angle"], character["hinges"]):
            pose_bone = made["rig"].evaluated_get(at(frame)).pose.bones[name]
            for offset, (axis, _, _) in enumerate(hinges):
                assert pose_bone.rotation_euler[axis] == pytest.approx(wanted[first + offset], abs=2e-3)


def test_the_fold_is_the_active_action_and_the_scenes_range_is_its(made):
    action, scene = made["action"], bpy.context.scene
    assert made["rig"].animation_data.action == action
    assert (scene.frame_start, scene.frame_end) == tuple(int(f) for f in action.frame_range) == (1, made["schedule"].last_frame)
    assert scene.frame_current == 1


def test_markers_of_the_action_name_the_joints_that_start_to_turn_there(made):
    rig, plan = made["rig"], made["schedule"]
    markers = {m.frame: m.name.split(", ") for m in rig.animation_data.action.pose_markers}
    assert sorted(markers) == [step.start for step in plan.steps]
    for step in plan.steps:
        before, after = (world_of_bones(rig, frame) for frame in (step.start, step.end))
        for name in markers[step.start]:
            parent = rig.pose.bones[name].parent.name
            turned = (before[parent].inverted() @ before[name]).to_quaternion().rotation_difference((after[parent].inverted() @ after[name]).to_quaternion())
            assert turned.angle > 0.01, name


def timeline():
    return sorted((m.frame, m.name) for m in bpy.context.scene.timeline_markers)


def test_the_timeline_has_the_same_markers_and_they_go_with_the_design(made):
    assert timeline() == sorted((m.frame, m.name) for m in made["action"].pose_markers) and len(timeline()) == len(made["schedule"].steps)
    bpy.context.scene.timeline_markers.new("mine", frame=7)
    taken = min(bpy.context.scene.timeline_markers, key=lambda m: m.frame)
    taken.name = "the artist's now"
    options = DesignOptions(frames=300)
    design.apply(bpy.context, made["result"], made["arrays"], made["character"], made["target"], options)
    names = [name for _, name in timeline()]
    assert "mine" in names and "the artist's now" in names and len(names) == len(made["schedule"].steps) + 2


def test_a_loop_folds_back_by_the_same_way_without_a_jump(made):
    plan = design.retimed(bpy.context.scene, made["rig"], DesignOptions(loop=True))
    scene, last = bpy.context.scene, made["schedule"].last_frame
    assert plan.last_frame == last and scene.frame_start == 1 and scene.frame_end == 2 * last - 2
    for back in (0, 1, 17.5, last - 1):
        there, again = world_of_bones(made["rig"], last - back), world_of_bones(made["rig"], last + back)
        assert all(scenes.close(there[n], again[n], 1e-4) for n in there), back
    first, after = world_of_bones(made["rig"], 1), world_of_bones(made["rig"], scene.frame_end + 1)
    assert all(scenes.close(first[n], after[n], 1e-4) for n in first)
    assert tuple(int(f) for f in made["action"].frame_range) == (1, last), "the action itself is the fold"
    design.retimed(scene, made["rig"], DesignOptions())
    assert scene.frame_end == last
    rest, beyond = world_of_bones(made["rig"], last), world_of_bones(made["rig"], last + 10)
    assert all(scenes.close(rest[n], beyond[n], 1e-5) for n in rest)


def test_another_length_is_the_same_fold_at_another_pace(made):
    rig, count = made["rig"], made["result"]["character"]["angle_count"]
    plan = design.retimed(bpy.context.scene, rig, DesignOptions(frames=37))
    assert plan.last_frame == 37 and bpy.context.scene.frame_end == 37
    assert tuple(int(f) for f in made["action"].frame_range) == (1, 37)
    assert [frame for frame, _ in timeline()] == [step.start for step in plan.steps]
    character = made["result"]["character"]
    for frame in (1, 8.3, 20, 37):
        wanted = plan.angles_at(frame, count)
        for name, first, hinges in zip(character["bodies"], character["first_angle"], character["hinges"]):
            pose_bone = rig.evaluated_get(at(frame)).pose.bones[name]
            for offset, (axis, _, _) in enumerate(hinges):
                assert pose_bone.rotation_euler[axis] == pytest.approx(wanted[first + offset], abs=2e-3)
    animation.use_slider(rig, True)
    rig["fold"] = 1.0
    rig.update_tag()
    bpy.context.view_layer.update()
    folded = world_of_bones(rig, 1)
    animation.use_slider(rig, False)
    wanted = world_of_bones(rig, 37)
    assert all(scenes.close(folded[n], wanted[n], 2e-3) for n in wanted)


def test_the_slider_folds_when_it_is_switched_on_and_adds_nothing_when_it_is_off(made):
    rig, last = made["rig"], made["schedule"].last_frame
    wanted = {f: world_of_bones(rig, f) for f in (1, (1 + last) / 2, last)}
    rig["fold"] = 0.7
    rig.update_tag()
    off = world_of_bones(rig, last)
    assert all(scenes.close(off[n], wanted[last][n], 1e-5) for n in off)
    animation.use_slider(rig, True)
    for frame, bones in wanted.items():
        rig["fold"] = (frame - 1) / (last - 1)
        rig.update_tag()
        bpy.context.view_layer.update()
        now = world_of_bones(rig, 1)
        assert all(scenes.close(now[n], bones[n], 2e-3) for n in now), frame
    animation.use_slider(rig, False)
    now = world_of_bones(rig, last)
    assert all(scenes.close(now[n], wanted[last][n], 1e-5) for n in now)


def test_schedules_first_frame_is_the_scenes(made):
    assert schedule.FIRST_FRAME == bpy.context.scene.frame_start
