# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps what a job found, as plain JSON text in the scene, and hands it to later jobs while it still fits."""

import json

from . import blocks, fingerprint, overlays, session, thumbnail

STORES = {"embedding": "embedding_stage", "path": "folding_stage"}  # what `gather` takes, and where it is kept
PAIRS_LISTED = 4
STAGE_OF = {"embedding": "embedding", "path": "folding"}


def stored(scene, names):
    """Of the named stored results those that still belong to the scene's inputs, as arguments for `gather`."""
    found = {}
    for name in names:
        group = getattr(scene.transformables, STORES[name])
        if fingerprint.fits(scene, STAGE_OF[name], group.stored_for, thorough=True):
            found[name] = json.loads(group.stored)
    if "path" in found and "embedding" not in found:
        del found["path"]  # a path leads from one folded pose only
    return found


def take_fingerprints(scene, until):
    """The inputs' fingerprints when a job begins: what changes while it runs makes its result out of date."""
    stages = session.STAGES[session.STAGES.index("embedding"):session.STAGES.index(until) + 1]
    return {stage: fingerprint.take(scene, stage) for stage in stages}


def keep(context, running, result, arrays, character, target, options):
    """Stores a job's result in the scene and, when there are parts, makes the objects. Gives a line for the user."""
    from ..bridge import design, division, edits, guide

    scene = context.scene
    made = None
    if result["finishing"] is not None:
        made = design.apply(context, result, arrays, character, target, options)
    _store(scene, running, "embedding", result["embedding"])
    scene.transformables.embedding_stage.made_with = json.dumps({"character": result["character"], "target": result["target"]})
    if made is not None:
        blocks.keep(scene, made["in_the_way"])
    if result["solutions"]:
        _list(context, running, result["solutions"], target)
    if running.from_guide:
        guide.remove(scene, character)
    if result["finishing"] is not None and "segmentation" in running.fingerprints:
        _store(scene, running, "segmentation", _shares(result))
        scene.transformables.segmentation_stage.seams = edits.seams_of(result, arrays, target)
        division.store(scene.transformables.segmentation_stage, result, arrays, target)
    if result["path"] is not None:
        _store(scene, running, "folding", result["path"])
    if running.until != "embedding":
        overlays.clear()
    return _summary(result)


def _store(scene, running, stage, value):
    group = getattr(scene.transformables, f"{stage}_stage")
    group.stored = json.dumps(value)
    group.stored_for = running.fingerprints[stage]


def _list(context, running, solutions, target):
    """Solutions into the list, in the place of those that the artist doesn't keep."""
    from ..bridge import mesh

    group = context.scene.transformables.embedding_stage
    for index in reversed(range(len(group.solutions))):
        if not group.solutions[index].kept:
            group.solutions.remove(index)
    vertices, triangles = mesh.read_triangles(context, target)
    first = len(group.solutions)
    for number, solution in enumerate(solutions):
        row = group.solutions.add()
        row.name, row.score = f"Pose {first + number + 1}", solution["value"]
        row.embedding, row.stored_for = json.dumps(solution), running.fingerprints["embedding"]
        row.thumbnail = thumbnail.draw(vertices, triangles, solution["points"])
    group.solution = first


def use(scene, solution):
    """Makes a listed pose the one that later stages start from; what they made of another one is out of date."""
    s = scene.transformables
    s.embedding_stage.stored, s.embedding_stage.stored_for = solution.embedding, solution.stored_for
    for stage in (s.segmentation_stage, s.folding_stage):
        stage.stored = stage.stored_for = ""


def _shares(result):
    parts, volume = result["finishing"]["parts"], result["target"]["volume"]
    return {part["bone"] if isinstance(part["bone"], str) else result["character"]["bodies"][part["bone"]]: part["volume"] / volume
            for part in parts}


def collisions_left(result):
    """In words, which parts still collide in a finished design; empty when none do."""
    if result["until"] != "finishing":
        return ""
    bodies = result["character"]["bodies"]
    pairs = sorted({tuple(sorted((bodies[c["bone_a"]], bodies[c["bone_b"]]))) for c in result["finishing"]["collisions"]})
    listed = ", ".join(f"{a} with {b}" for a, b in pairs[:PAIRS_LISTED])
    more = f" and {len(pairs) - PAIRS_LISTED} more pairs" if len(pairs) > PAIRS_LISTED else ""
    return f"Parts still collide on the way: {listed}{more}. Try another seed" if pairs else ""


def _summary(result):
    seconds = f"{result['seconds']['total']:.0f} s"
    if result["stopped"]:
        return f"Stopped after {seconds}: the best pose so far is kept; score {result['embedding']['terms']['total']:.4g}"
    if result["solutions"]:
        return f"{len(result['solutions'])} different poses found in {seconds}; the best has a score of {result['solutions'][0]['value']:.4g}"
    if result["until"] == "embedding":
        return f"Folded pose found in {seconds}; score {result['embedding']['terms']['total']:.4g}"
    if result["until"] == "segmentation":
        return f"Target divided into {len(result['finishing']['parts'])} parts in {seconds}"
    if result["until"] == "folding":
        left = len(result["path"]["collisions"])
        return f"Fold of {len(result['path']['moves'])} moves planned in {seconds}" + (f"; {left} collisions to carve" if left else "")
    made = f"Design of {len(result['finishing']['parts'])} parts made in {seconds}"
    return f"{made}, but parts still collide" if collisions_left(result) else f"{made}; no collision was found"


def show_pose(event):
    """Draws a pose that the worker found: its bones' ends in Blender's world."""
    overlays.show(event["points"])
    session.redraw()
