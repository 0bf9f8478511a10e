# SPDX-License-Identifier: GPL-3.0-or-later
"""Pairs of parts in each other's way: kept as a list in the scene, and shown in the 3D view at their moment."""

import json

import bpy

from . import block_overlay, session, settings


def keep(scene, rows):
    """Makes these rows of core/blocks.py the list."""
    stage = scene.transformables.folding_stage
    stage.blocks.clear()
    stage.block = 0  # while the list is empty, so that nothing is shown before the artist asks
    for row in rows:
        stage.blocks.add().row = json.dumps(row)
    suggest_lock(scene)


def move_frames(scene, plan):
    """The rows' moments on another schedule of the same moves."""
    for item in scene.transformables.folding_stage.blocks:
        row = item.facts()
        if row["move"] is not None:
            row["frame"] = round(plan.frame_of(row["move"], row["fraction"]), 3)
            item.row = json.dumps(row)


def chosen(scene):
    """The row that is chosen in the list, or None."""
    stage = scene.transformables.folding_stage
    return stage.blocks[stage.block].facts() if 0 <= stage.block < len(stage.blocks) else None


def joints(scene):
    """Joints that could be locked for the chosen pair's sake: those that turn then, and the two bones' own: [(bone, axis, angle's index)]."""
    row, made_with = chosen(scene), scene.transformables.embedding_stage.made_with
    if row is None or not made_with:
        return []
    character = json.loads(made_with)["character"]
    found = [(joint["bone"], joint["axis"], joint["angle"]) for joint in row["joints"]]
    for body, first, hinges in zip(character["bodies"], character["first_angle"], character["hinges"]):
        if body in row["bones"]:
            found += [(body, "XYZ"[hinge[0]], first + k) for k, hinge in enumerate(hinges)]
    return list(dict.fromkeys(found))


def folded_angle(scene, angle):
    """Where a hinge stands in the folded pose, radians."""
    stored = scene.transformables.embedding_stage.stored
    angles = json.loads(stored)["angles"] if stored else []
    return angles[angle] if 0 <= angle < len(angles) else 0.0


def suggest_lock(scene):
    """Fills in the first joint that could be locked, at the angle where it is."""
    found = joints(scene)
    if found:
        scene.transformables.folding_stage.lock_joint = str(found[0][2])


def hide():
    block_overlay.clear()


def rig_of(scene):
    """The rig of the scene's design, or None."""
    character, target = settings.picked(scene, "character"), settings.picked(scene, "target")
    return next((obj for obj in scene.objects if obj.get("transformable_role") == "rig" and character is not None and target is not None
                 and obj.get("transformable_source") == character.name and obj.get("transformable_target") == target.name), None)


def show(context, scene):
    """Goes to the chosen pair's worst moment, selects its two parts, and draws both and the place. False when there is no such design."""
    from ..bridge import animation

    row, rig = chosen(scene), rig_of(scene)
    if row is None or rig is None:
        block_overlay.clear()
        return False
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    if rig.animation_data.action is None:
        animation.use_slider(rig, False)  # the slider holds the rig still
    scene.frame_set(int(row["frame"]), subframe=row["frame"] % 1)
    parts = [next((o for o in rig.children if o.get("transformable_bone") == bone), None) for bone in row["bones"]]
    for obj in context.view_layer.objects:
        obj.select_set(obj in parts)
    if parts[0] is not None:
        context.view_layer.objects.active = parts[0]
    block_overlay.show([part.name for part in parts if part is not None], rig.name, row)
    session.redraw()
    return True
