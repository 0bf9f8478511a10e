# SPDX-License-Identifier: GPL-3.0-or-later
"""The embedding's settings as what a job calls steering (core/steering.py)."""

import json

import bpy

from ..bridge import guide
from ..core.steering import USUAL_WEIGHTS
from . import settings


def of(scene):
    """Steering for a job; empty when nothing is steered."""
    steering = _settings(scene)
    pose = _pose(scene) if "locked" in steering or "pinned" in steering else None
    return {**steering, "pose": pose} if pose else steering


def _settings(scene):
    group = scene.transformables.embedding_stage
    weights = {term: usual * getattr(group.weights, term) for term, usual in USUAL_WEIGHTS.items() if getattr(group.weights, term) != 1}
    locked, pinned = [b.name for b in group.bones if b.lock], [b.name for b in group.bones if b.pin]
    proportions = {b.name: [1.0, 1.0] if b.proportion == "keep" else [b.least, b.largest] for b in group.bones if b.proportion != "common"}
    steering = {"weights": weights, "locked": locked, "pinned": pinned, "proportions": proportions,
                "apart": [[pair.bone, pair.other] for pair in group.apart]}
    return {key: value for key, value in steering.items() if value}


def _pose(scene):
    """The pose that locks and pins hold: the pose rig's while there is one, else the folded pose that was found."""
    character, stored = settings.picked(scene, "character"), scene.transformables.embedding_stage.stored
    rig = guide.of(scene, character) if character is not None else None
    if rig is not None:
        return guide.read(bpy.context, rig)
    return json.loads(stored) if stored else None


def inputs(scene):
    """What of it a result depends on, as JSON would have it. The pose itself is left out: it is a result."""
    return [[key, value] for key, value in _settings(scene).items()]
