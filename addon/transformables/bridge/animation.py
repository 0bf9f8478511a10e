# SPDX-License-Identifier: GPL-3.0-or-later
"""The fold as one Action, and a slider for it. The only module that knows how Actions differ between Blenders."""
import json

import bpy
from mathutils import Matrix, Vector
import numpy as np

LINEAR, EASE, HOLD = ("LINEAR", "AUTO"), ("SINE", "EASE_IN_OUT"), ("CONSTANT", "AUTO")


MARKERS = "transformable_markers"  # of the rig: the timeline's markers that are its own, as [name, frame]


def new_fold(rig, layout, schedule, result):
    """Makes the fold and sets it as the rig's action: frame 1 character mode, the last one object mode."""
    action = bpy.data.actions.new(f"{rig.name} fold")
    if rig.animation_data is None:
        rig.animation_data_create()
    curves = _Curves(action, rig)
    keys = schedule.keys(result["character"]["angle_count"])
    for body, hinges in enumerate(layout.hinges):
        for offset, (axis, _, _) in enumerate(hinges):
            points = [(frame, value, EASE if moves_on else HOLD) for frame, value, moves_on in keys[layout.first_angle[body] + offset]]
            curves.add(layout.lead(body), "rotation_euler", axis, points)
    _move_root(curves, rig, layout, schedule, result)
    _mark_moves(action, layout, schedule)
    return action


def play(scene, rig, schedule, loop):
    """Sets the scene's range to the fold, marks its moves in the timeline, and lets it fold back again when it is a loop."""
    scene.frame_start, scene.frame_end = 1, schedule.scene_end(loop)
    unmark(scene, rig)
    action = fold_of(rig)
    markers = [scene.timeline_markers.new(marker.name, frame=marker.frame) for marker in action.pose_markers]
    rig[MARKERS] = json.dumps([[marker.name, marker.frame] for marker in markers])
    for curve in _curves_of(action):
        for modifier in [m for m in curve.modifiers if m.type == "CYCLES"]:
            curve.modifiers.remove(modifier)
        if loop:
            modifier = curve.modifiers.new("CYCLES")
            modifier.mode_before, modifier.mode_after = "NONE", "MIRROR"


def unmark(scene, rig):
    """Takes the rig's markers out of the timeline. One that the artist has moved or renamed is the artist's."""
    own = [tuple(marker) for marker in json.loads(rig.get(MARKERS, "[]"))]
    for marker in [m for m in scene.timeline_markers if (m.name, m.frame) in own]:
        scene.timeline_markers.remove(marker)


def retime(rig, before, after):
    """Moves the fold's keys from one schedule to another of the same moves; keys in between keep their place between the moves."""
    def moved(frame):
        return float(np.interp(frame, before.waypoints(), after.waypoints()))

    action = fold_of(rig)
    for curve in _curves_of(action):
        for key in curve.keyframe_points:
            key.co.x = moved(key.co.x)
        curve.update()
    for marker in action.pose_markers:
        marker.frame = round(moved(marker.frame))
    for pose_bone in rig.pose.bones:
        for constraint in pose_bone.constraints:
            if constraint.type == "ACTION" and constraint.name == "Fold":
                constraint.frame_end = after.last_frame


def fold_of(rig):
    """The rig's fold, also while the slider is on."""
    return next((c.action for b in rig.pose.bones for c in b.constraints if c.type == "ACTION" and c.name == "Fold"), None)


def _curves_of(action):
    if hasattr(action, "slots"):
        return action.layers[0].strips[0].channelbag(action.slots[0]).fcurves
    return action.fcurves


def _mark_moves(action, layout, schedule):
    """A marker of the action where each move starts, named after the joints that turn."""
    owners = {layout.first_angle[body] + k: layout.lead(body) for body, hinges in enumerate(layout.hinges) for k in range(len(hinges))}
    for step in schedule.steps:
        names = dict.fromkeys(owners[angle] for angle, _, _ in step.turns)  # in order, each once
        action.pose_markers.new(", ".join(names)).frame = step.start


def _move_root(curves, rig, layout, schedule, result):
    """The whole way long the root goes straight, turning about one axis, to where object mode has it."""
    location, (axis, angle) = root_basis(rig, layout, result)
    first, last = 1, schedule.last_frame
    bone = layout.lead(0)
    for channel in range(3):
        curves.add(bone, "location", channel, [(first, 0.0, EASE), (last, location[channel], HOLD)])
        curves.add(bone, "rotation_axis_angle", channel + 1, [(first, axis[channel], HOLD), (last, axis[channel], HOLD)])
    curves.add(bone, "rotation_axis_angle", 0, [(first, 0.0, EASE), (last, angle, HOLD)])


def root_basis(rig, layout, result):
    """The root bone's own location, axis and angle in object mode."""
    root = np.array(result["embedding"]["root"]).reshape(4, 4).T
    world = Matrix(root[:3, :3].tolist()).to_4x4()
    world.translation = Vector(root[:3, 3] * layout.unit) + Vector(result["target"]["centre"])
    rest = rig.matrix_world @ rig.data.bones[layout.lead(0)].matrix_local
    basis = rest.inverted() @ world
    return basis.to_translation(), basis.to_quaternion().to_axis_angle()


class _Curves:
    """Where the action's curves for one object go: the action itself to 4.3, a channel bag of a slot from 4.4."""

    def __init__(self, action, rig):
        self._slotted = hasattr(action, "slots")
        if self._slotted:
            slot = action.slots.new(id_type="OBJECT", name=rig.name)
            strip = action.layers.new("Fold").strips.new(type="KEYFRAME")
            self._bag = strip.channelbag(slot, ensure=True)
            rig.animation_data.action = action
            rig.animation_data.action_slot = slot
        else:
            action.id_root = "OBJECT"  # else constraints that use the action are silently invalid
            rig.animation_data.action = action
            self._bag = action

    def add(self, bone, channel, index, points):
        """One curve; points are (frame, value, (interpolation, easing) towards the next)."""
        path = f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{channel}'
        if self._slotted:
            curve = self._bag.fcurves.new(path, index=index)
            group = self._bag.groups.get(bone) or self._bag.groups.new(bone)
            curve.group = group
        else:
            curve = self._bag.fcurves.new(path, index=index, action_group=bone)
        curve.keyframe_points.add(len(points))
        for key, (frame, value, (interpolation, easing)) in zip(curve.keyframe_points, points):
            key.co = (frame, value)
            key.handle_left_type = key.handle_right_type = "VECTOR"
            key.interpolation, key.easing = interpolation, easing
        curve.update()


def add_slider(rig, action, last_frame):
    """`fold`, 0 to 1, on the rig: drives the fold while `use_fold_slider` is 1.

    The active action and the slider would add up, so the slider is off at first; `use_slider` switches between them.
    """
    for name, description in (("fold", "0: character mode, 1: object mode; used while the slider is on"),
                              ("use_fold_slider", "1: the slider folds, 0: the action does")):
        rig[name] = 0.0
        rig.id_properties_ui(name).update(min=0.0, max=1.0, soft_min=0.0, soft_max=1.0, description=description)
    for pose_bone in rig.pose.bones:
        constraint = pose_bone.constraints.new("ACTION")
        constraint.name = "Fold"
        constraint.use_eval_time = True
        constraint.action = action
        if hasattr(constraint, "action_slot"):
            constraint.action_slot = rig.animation_data.action_slot
        constraint.frame_start, constraint.frame_end = 1, last_frame
        constraint.mix_mode = "BEFORE_FULL"  # the artist's own pose goes on top
        _drive(constraint, "eval_time", rig, "fold")
        _drive(constraint, "influence", rig, "use_fold_slider")


def _drive(constraint, attribute, rig, name):
    driver = constraint.driver_add(attribute).driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "value"
    variable.targets[0].id = rig
    variable.targets[0].data_path = f'["{name}"]'
    driver.expression = "value"  # simple enough to run without permission for scripts


def use_slider(rig, on):
    """Lets the slider fold the rig instead of its action, or the action again."""
    action = fold_of(rig)
    rig["use_fold_slider"] = 1.0 if on else 0.0
    rig.animation_data.action = None if on else action
    if not on and hasattr(rig.animation_data, "action_slot"):
        rig.animation_data.action_slot = action.slots[0]
    for pose_bone in rig.pose.bones:
        pose_bone.matrix_basis = Matrix()
    rig.update_tag()
