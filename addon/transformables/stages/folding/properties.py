# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which the joints unfold, and which parts are in each other's way meanwhile."""

import json
import math

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...ui import blocks


class TransformablesBlock(bpy.types.PropertyGroup):
    """A pair of parts in each other's way: a row of core/blocks.py, as JSON text."""

    row: StringProperty(options={"HIDDEN"})

    def facts(self):
        return json.loads(self.row)


_listed = []  # Blender needs the items' text to live on


def _joint_items(self, context):
    found = blocks.joints(self.id_data)
    _listed[:] = [(str(angle), f"{bone} {axis}", "The joint of this bone, about this axis of its own", angle) for bone, axis, angle in found]
    return _listed


def _show_block(self, context):
    blocks.suggest_lock(self.id_data)
    blocks.show(context, self.id_data)


def _show_angle(self, context):
    self.lock_angle = blocks.folded_angle(self.id_data, int(self.lock_joint))


class TransformablesFoldingSettings(bpy.types.PropertyGroup):
    stored: StringProperty(
        name="Fold Path", options={"HIDDEN"},
        description="The order in which the joints turn, as JSON text; Finishing starts from it")
    stored_for: StringProperty(options={"HIDDEN"})
    seconds: FloatProperty(
        name="Search Time (s)", default=20, min=0.1, max=3600, soft_min=1, soft_max=120, precision=1,
        description="Target time for the search of the order in which joints turn. More time: more orders are tried. On a machine that is "
                    "too slow the best order found by then is taken, and you are told")
    frames: IntProperty(
        name="Length", default=0, min=0, max=100000, description="Frames from character to object. 0: as long as the joints need, 5 to 10 seconds")
    together: BoolProperty(
        name="Joints Together", default=True,
        description="Let joints turn at the same time where it is proved that no parts touch. Off: one joint, or mirrored pair, after the other")
    loop: BoolProperty(name="Fold Back Again", description="Let the timeline go back to the character after the object, so that it repeats without a jump")
    blocks: CollectionProperty(
        type=TransformablesBlock, name="In the Way", description="Pairs of parts in each other's way on the fold, worst first")
    block: IntProperty(
        name="Pair", update=_show_block, description="The pair of parts that is looked at. Choosing one shows the moment and the place")
    lock_joint: EnumProperty(name="Joint", items=_joint_items, update=_show_angle, description="The joint to hold at an angle in the folded pose")
    lock_angle: FloatProperty(
        name="Angle", subtype="ANGLE", min=-math.pi, max=math.pi, description="Where to hold it in the folded pose; 0 is where it rests in the character")


CLASSES = (TransformablesBlock, TransformablesFoldingSettings)
