# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for the folded pose: what steers it, the pose that it found, and others to choose from."""

import json

import bpy
from bpy.props import (BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty,
                       StringProperty)

from ...core.steering import USUAL_WEIGHTS
from ...ui import overlays, session


def _share(term):
    """The term's part of the score, in percent: what its bar in the panel shows."""
    def percent(self):
        terms = json.loads(self.embedding)["terms"] if self.embedding else {}
        total = terms.get("total", 0.0)
        return 100.0 * USUAL_WEIGHTS[term] * terms.get(term, 0.0) / total if total > 0 else 0.0
    return percent


def _bar(term, name, description):
    return FloatProperty(name=name, subtype="PERCENTAGE", min=0, max=100, precision=0, get=_share(term), description=description)


class TransformablesSolution(bpy.types.PropertyGroup):
    """One folded pose: the pose as JSON text, and how good it is."""

    embedding: StringProperty(options={"HIDDEN"}, description="The folded pose, as JSON text")
    stored_for: StringProperty(options={"HIDDEN"})
    thumbnail: StringProperty(options={"HIDDEN"}, description="A small picture of the pose in the target, packed as text")
    score: FloatProperty(name="Score", description="How good this pose is: low is good")
    kept: BoolProperty(name="Keep", description="Leave this pose in the list when you explore again")
    compact: _bar("compact", "Compactness", "Part of the score from places of the target that are far from any bone")
    skin: _bar("skin", "Skin", "Part of the score from skin that has to move out of the way when joints turn")
    skeleton: _bar("skeleton", "Collisions", "Part of the score from bones that run into each other")
    protrude: _bar("protrude", "Sticking Out", "Part of the score from bones that stick out of the target")
    unfold: _bar("unfold", "Unfolding", "Part of the score from parts that get in each other's way when the joints unfold, roughly")


class TransformablesSteeredBone(bpy.types.PropertyGroup):
    """What the search may do with one bone; `name` is the bone's."""

    lock: BoolProperty(name="Lock", description="Keep this bone's joint as it is in the pose rig, or else in the folded pose; at rest when there is neither")
    pin: BoolProperty(name="Pin", description="Keep this bone where it is in the target, as the pose rig has it, or else the folded pose")
    proportion: EnumProperty(
        name="Proportions", default="common", description="How much longer or shorter this bone may become",
        items=(("common", "As All", "As the Proportions setting says"), ("keep", "Keep", "Keep the length that the character has"),
               ("own", "Own", "Between bounds of its own")))
    least: FloatProperty(name="Shortest", default=0.6, min=0.05, max=20, description="Shortest this bone may become, times its length")
    largest: FloatProperty(name="Longest", default=1.6, min=0.05, max=20, description="Longest this bone may become, times its length")


def _weight(name, description):
    return FloatProperty(name=name, default=1, min=0, soft_max=10, max=1000, description=f"{description}. 1 is usual, 0 switches it off")


class TransformablesPair(bpy.types.PropertyGroup):
    """Two bones whose parts should get in each other's way less."""

    bone: StringProperty(name="Bone", description="One of the two bones")
    other: StringProperty(name="Other Bone", description="The other one")


class TransformablesWeights(bpy.types.PropertyGroup):
    """How much each term counts, times what is usual."""

    compact: _weight("Compactness", "How much it counts that every place of the target has a bone near")
    skin: _weight("Skin", "How much it counts that little skin is in the way of turning joints")
    skeleton: _weight("Collisions", "How much it counts that bones keep clear of each other")
    protrude: _weight("Staying Inside", "How much it counts that bones stay inside the target")
    unfold: _weight("Unfolding", "How much it counts that parts keep out of each other's way when the joints unfold, so that less has to be carved away")
    morphology: _weight("Proportions", "How much it counts that bones keep their lengths")


def _show_solution(self, context):
    if 0 <= self.solution < len(self.solutions):
        overlays.show(json.loads(self.solutions[self.solution].embedding)["points"])
        session.redraw()


class TransformablesEmbeddingSettings(bpy.types.PropertyGroup):
    seed: IntProperty(
        name="Seed", default=0, min=0,
        description="Try another number to get another way of folding; the same number gives the same design again")
    symmetry: EnumProperty(
        name="Symmetry", default="auto",
        description="Whether the left and right side of the character fold in the same way",
        items=(("auto", "Automatic", "Fold both sides alike when the character and the target are both symmetric and such a pose fits"),
               ("on", "On", "Always fold both sides alike; the character and the target must be symmetric"),
               ("off", "Off", "Let each side fold in its own way")))
    proportions: BoolProperty(
        name="Proportions", default=True,
        description="Let single bones become longer or shorter, so that the character fills the target better")
    weights: PointerProperty(type=TransformablesWeights)
    bones: CollectionProperty(
        type=TransformablesSteeredBone, name="Bones", description="What the search may do with each bone of the character")
    bone: IntProperty(name="Bone", description="The bone whose settings are shown")
    apart: CollectionProperty(
        type=TransformablesPair, name="Keep Apart", description="Pairs of parts that should get in each other's way less: of several poses, one that is good for them is taken")
    explore_count: IntProperty(
        name="Poses", default=5, min=2, max=50, description="How many really different folded poses to look for")
    explore_difference: FloatProperty(
        name="Difference", default=15, min=1, max=90, subtype="PERCENTAGE", precision=0,
        description="How much of the target must belong to another bone for two poses to count as different")
    solutions: CollectionProperty(
        type=TransformablesSolution, name="Poses", description="Different folded poses that were found, to choose from")
    solution: IntProperty(name="Pose", description="The pose that is drawn in the 3D view", update=_show_solution)
    stored: StringProperty(
        name="Folded Pose", options={"HIDDEN"},
        description="The folded pose that was found, as JSON text; later stages start from it")
    stored_for: StringProperty(options={"HIDDEN"})
    made_with: StringProperty(options={"HIDDEN"}, description="The character and target that the pose was found for, as JSON text")


CLASSES = (TransformablesSolution, TransformablesSteeredBone, TransformablesPair, TransformablesWeights, TransformablesEmbeddingSettings)
