# SPDX-License-Identifier: GPL-3.0-or-later
"""Results in Blender, from numbers made by hand: rig, parts, fold. What they promise is CONTRACT.md's.

The folded pose here is made up, and the parts are boxes: what is tested is that Blender shows exactly what was said.
"""
import itertools
import math

import bpy
from mathutils import Euler, Matrix, Quaternion, Vector
import numpy as np
import pytest
import scenes
from transformables.bridge import animation, design, printing
from transformables.core import kinematics, schedule
from transformables.core.options import DesignOptions, UserError

FIT, UNITS = 0.4, 0.25  # target units for one unit of the armature; for one Blender unit
BOX = np.array(list(itertools.product((-0.01, 0.01), (0.0, 0.05), (-0.02, 0.02))))
BOX_FACES = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
                      (1, 5, 7), (1, 7, 3)], np.int32)
ROOT = Matrix.Translation((0.03, -0.02, 0.05)) @ Quaternion((0.3, 0.5, -0.7, 0.4)).normalized().to_matrix().to_4x4()


def hand_made(character_obj, target_obj, options):
    """(result, arrays) as a worker would give them, for a made-up folded pose."""
    message, arrays = design.gather(character_obj, target_obj, options)
    names, parents, hinges = (message["character"][k] for k in ("names", "parents", "hinges"))
    bodies, members = {}, []
    for i in range(len(names)):  # a bone without hinges is one body with its parent
        if parents[i] >= 0 and not hinges[i]:
            bodies[i] = bodies[parents[i]]
            members[bodies[i]].append(i)
        else:
            bodies[i] = len(members)
            members.append([i])
    body_hinges = [hinges[m[0]] for m in members]
    first = [sum(len(h) for h in body_hinges[:i]) for i in range(len(members))]
    count = sum(len(h) for h in body_hinges)
    angles = [0.9 * (hinge[2] if i % 2 else hinge[1]) for i, hinge in enumerate(h for hs in body_hinges for h in hs)]
    moves = [[(0, angles[0], 0.0), (1, angles[1], 0.0)]] + [[(i, angles[i], 0.0)] for i in range(2, count)]
    moves.append([])  # a move of nothing must do no harm
    result = {
        "until": "finishing", "stopped": False, "options": options.as_dict(), "native_version": "none", "seconds": {"total": 1.0}, "warnings": [],
        "peak_memory_mb": 1.0, "names": message["names"],
        "character": {"names": names, "parents": parents, "bodies": [names[m[0]] for m in members], "members": members,
                      "body_parents": [bodies[parents[m[0]]] if parents[m[0]] >= 0 else -1 for m in members],
                      "hinges": body_hinges, "first_angle": first, "angle_count": count, "mirrored": False, "scale": FIT},
        "target": {**message["target"], "scale": UNITS, "centre": list(target_obj.location), "volume": 0.1, "grid": [64] * 3, "mirror_axis": None},
        "embedding": {"root": [ROOT[r][c] for c in range(4) for r in range(4)], "angles": angles,
                      "morphology": [0.8 + 0.05 * i for i in range(len(members))], "terms": {"total": 1.0}, "symmetric": False},
        "path": {"moves": moves, "collisions": [], "overlap_volume": 0.0},
        "finishing": {"parts": [{"bone": i, "volume": 1e-5} for i in range(len(members))], "preview": False, "collisions": [],
                      "minimum_clearance": 0.001, "carved_volume_pct": 0.0, "filled_volume_pct": 99.0, "pinned": [],
                      "certificate": {"holds": True, "gap": 0.001, "open": []}}}
    out = {name: arrays[name] for name in ("heads", "tails", "axes", "rotation")}
    for i in range(len(members)):
        out[f"part_{i}_vertices"] = ("d", BOX.astype(np.float64).tobytes())
        out[f"part_{i}_triangles"] = ("i", BOX_FACES.tobytes())
    return result, out


@pytest.fixture
def scene(empty_scene):
    character = scenes.placed(scenes.walker(), rotation=(0, 10, 70), location=(-3, 4, 1), scale=(2, 2, 2))
    target = scenes.cube("box", 2.0, (4, 5, 6))
    return character, target


@pytest.fixture
def made(scene):
    options = DesignOptions()
    result, arrays = hand_made(*scene, options)
    return {**design.apply(bpy.context, result, arrays, *scene, options), "result": result, "arrays": arrays,
            "character": scene[0], "target": scene[1]}


def at(frame):
    whole = math.floor(frame + 1e-9)
    bpy.context.scene.frame_set(whole, subframe=min(max(frame - whole, 0.0), 0.9999))
    return bpy.context.evaluated_depsgraph_get()


def world_of_bones(rig, frame):
    evaluated = rig.evaluated_get(at(frame))
    return {b.name: evaluated.matrix_world @ b.matrix for b in evaluated.pose.bones}


def samples(made, step=1.5):
    return np.arange(1, made["schedule"].last_frame + 1e-6, step)


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


def test_schedules_first_frame_is_the_scenes(made):
    assert schedule.FIRST_FRAME == bpy.context.scene.frame_start


@pytest.mark.parametrize("file_format", ["stl", "3mf", "assembled"])
def test_parts_are_exported_in_millimetres_at_the_designs_size(scene, tmp_path, file_format):
    options = DesignOptions(size_mm=80.0)
    made = design.apply(bpy.context, *hand_made(*scene, options), *scene, options)
    names = printing.export(made["rig"], str(tmp_path / "new" / "folder"), file_format)
    assert sorted(p.name for p in (tmp_path / "new" / "folder").iterdir()) == sorted(names), "nothing but the parts"
    assert len(names) == (len(made["parts"]) if file_format == "stl" else 1)
    for name, points, triangles in printing.parts_of(made["rig"]):
        size = np.ptp(np.array(points), axis=0)
        assert size == pytest.approx(np.ptp(BOX, axis=0) * 80.0 / 0.5, rel=1e-5), name  # 0.5 target units are as long as the size
        assert len(triangles) == len(BOX_FACES)


def test_assembled_parts_stand_to_each_other_as_the_scene_shows_them(scene, made):
    rig, scale = made["rig"], made["rig"][printing.MM]
    for frame in (bpy.context.scene.frame_start, bpy.context.scene.frame_end):
        bpy.context.scene.frame_set(frame)
        shown = {o["transformable_bone"]: np.array([rig.matrix_world.inverted() @ o.matrix_world @ v.co for v in o.data.vertices]) for o in made["parts"]}
        exported = {name: np.array(points) for name, points, _ in printing.parts_of(rig, assembled=True)}
        shift = next(exported[name][0] - shown[name][0] * scale for name in exported)
        for name, points in exported.items():
            assert np.abs(points - shown[name] * scale - shift).max() < 1e-3, name
        assert min(points[:, 2].min() for points in exported.values()) == pytest.approx(0, abs=1e-4), "on the plate"


def test_a_design_without_its_size_or_a_folder_that_cannot_be_written_is_refused_in_words(made, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="choose a folder"):
        printing.export(made["rig"], str(tmp_path / "file" / "below"))
    del made["rig"][printing.MM]
    with pytest.raises(UserError, match="older version"):
        printing.export(made["rig"], str(tmp_path))
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
