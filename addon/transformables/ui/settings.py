# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's settings: who folds into what, and each stage's own settings and stored result."""

import bpy
from bpy.props import PointerProperty

from ..stages.character.properties import TransformablesCharacterSettings
from ..stages.embedding.properties import TransformablesEmbeddingSettings
from ..stages.finishing.properties import TransformablesFinishingSettings
from ..stages.folding.properties import TransformablesFoldingSettings
from ..stages.segmentation.properties import TransformablesSegmentationSettings
from ..stages.target.properties import TransformablesTargetSettings
from . import session

MADE_BY_A_DESIGN = ("rig", "part", "guide")


def candidates(scene, kind):
    """Objects of the scene that may be picked: those of the type that no design made."""
    return [obj for obj in scene.objects if obj.type == kind and obj.get("transformable_role") not in MADE_BY_A_DESIGN]


def _is_character(settings, obj):
    return obj in candidates(settings.id_data, "ARMATURE")


def _is_target(settings, obj):
    return obj in candidates(settings.id_data, "MESH")


class TransformablesSettings(bpy.types.PropertyGroup):
    character: PointerProperty(
        type=bpy.types.Object, name="Character", poll=_is_character,
        description="The armature that folds up. When the scene has only one, it is taken by itself")
    target: PointerProperty(
        type=bpy.types.Object, name="Target", poll=_is_target,
        description="The mesh object that the character folds into. When the scene has only one, it is taken by itself")
    character_stage: PointerProperty(type=TransformablesCharacterSettings)
    target_stage: PointerProperty(type=TransformablesTargetSettings)
    embedding_stage: PointerProperty(type=TransformablesEmbeddingSettings)
    segmentation_stage: PointerProperty(type=TransformablesSegmentationSettings)
    folding_stage: PointerProperty(type=TransformablesFoldingSettings)
    finishing_stage: PointerProperty(type=TransformablesFinishingSettings)


def picked(scene, which):
    """The object picked as "character" or "target": the user's choice while it is in the scene, else the only candidate, else None."""
    choice = getattr(scene.transformables, which)
    if choice is not None:
        return choice if choice.name in scene.objects else None
    found = candidates(scene, "ARMATURE" if which == "character" else "MESH")
    return found[0] if len(found) == 1 else None


def edits(scene):
    """The artist's edits of the segmentation that are switched on."""
    return [edit for edit in scene.transformables.segmentation_stage.edits if edit.enabled]


def missing(scene):
    """In words, what has to be picked before anything can run; empty when nothing."""
    if picked(scene, "character") is None:
        return "Pick the character: an armature object of this scene"
    if picked(scene, "target") is None:
        return "Pick the target: a mesh object of this scene"
    return ""


def _percentage(_):
    running = session.current()
    return 100.0 * running.fraction if running else 0.0


def register():
    bpy.utils.register_class(TransformablesSettings)
    bpy.types.Scene.transformables = PointerProperty(type=TransformablesSettings)
    bpy.types.WindowManager.transformables_progress = bpy.props.FloatProperty(
        name="Progress", subtype="PERCENTAGE", min=0, max=100, precision=0, get=_percentage,
        description="How far the stage that is running has come")


def unregister():
    del bpy.types.WindowManager.transformables_progress
    del bpy.types.Scene.transformables
    bpy.utils.unregister_class(TransformablesSettings)
