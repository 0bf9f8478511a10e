# SPDX-License-Identifier: GPL-3.0-or-later
"""The embedding's settings as what a job calls steering (core/steering.py)."""

import json

from ..core.steering import USUAL_WEIGHTS


def of(scene):
    """Steering for a job; empty when nothing is steered."""
    group = scene.transformables.embedding_stage
    weights = {term: usual * getattr(group.weights, term) for term, usual in USUAL_WEIGHTS.items() if getattr(group.weights, term) != 1}
    locked, pinned = [b.name for b in group.bones if b.lock], [b.name for b in group.bones if b.pin]
    proportions = {b.name: [1.0, 1.0] if b.proportion == "keep" else [b.least, b.largest] for b in group.bones if b.proportion != "common"}
    steering = {"weights": weights, "locked": locked, "pinned": pinned, "proportions": proportions}
    steering = {key: value for key, value in steering.items() if value}
    if (locked or pinned) and group.stored:
        steering["pose"] = json.loads(group.stored)
    return steering


def inputs(scene):
    """What of it a result depends on, as JSON would have it. The pose itself is left out: it is a result."""
    return [[key, value] for key, value in of(scene).items() if key != "pose"]
