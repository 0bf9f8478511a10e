# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist wants of the division of the target among the bones, and what the last one gave."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

KINDS = (("inhibit", "No Growth", "The bone's part stays close to its skeleton; its neighbours take the room", "FREEZE", 0),
         ("remove", "No Skin", "The bone has no skin, only its bare skeleton; its neighbours take the room", "REMOVE", 1),
         ("keep_whole", "Keep Whole", "What a vertex group of the target holds ends in one part, such as a wheel or a face", "MESH_CIRCLE", 2),
         ("assign", "Assign to Bone", "What a vertex group of the target holds ends in the part of one bone", "BONE_DATA", 3),
         ("move_seam", "Moved Seam", "The line between two parts runs where it was dragged to", "MOD_CURVE", 4),
         ("bone_gives", "Bone Gives Room", "Where the bone's part and its parent's would collide as their joint turns, the bone gives material to its parent", "TRIA_UP", 5),
         ("parent_gives", "Parent Gives Room", "Where the bone's part and its parent's would collide as their joint turns, the parent gives material to the bone", "TRIA_DOWN", 6))
TO_ADD = tuple(kind for kind in KINDS if kind[0] != "move_seam")  # a seam is added by dragging it


class TransformablesEdit(bpy.types.PropertyGroup):
    """One wish; they are kept with the scene and applied whenever the target is divided again."""

    enabled: BoolProperty(name="Use", default=True, description="Heed this wish when the target is divided")
    kind: EnumProperty(name="Kind", items=KINDS, default="inhibit", description="What is wished for")
    bone: StringProperty(name="Bone", description="The bone that this is about")
    group: StringProperty(name="Vertex Group", description="The target's vertex group; faces count whose vertices all have at least half the weight")
    other: StringProperty(name="Other Bone", options={"HIDDEN"}, description="The bone on the seam's other side")
    points: StringProperty(
        name="Seam", options={"HIDDEN"}, description="Where the seam's points were and are to be, in the target's own space, as JSON text")
    thickness_mm: FloatProperty(
        name="Thickness (mm)", default=0, min=0, soft_max=20, max=1000, precision=1,
        description="How far the part may reach beyond the bone's skeleton, in millimetres of the printed size")

    def label(self):
        words = next(row[1] for row in KINDS if row[0] == self.kind)
        if self.kind == "move_seam":
            return f"{words}: {self.bone}, {self.other}"
        return f"{words}: {self.group or self.bone}" if self.group or self.bone else words


class TransformablesSegmentationSettings(bpy.types.PropertyGroup):
    edits: CollectionProperty(type=TransformablesEdit, description="What the artist wants of the parts; heeded whenever the target is divided")
    transfer: EnumProperty(
        name="Room at Joints", default="auto", description="How two parts that share a joint make room for its turn",
        items=(("auto", "Automatic", "Whichever way moves less, joint by joint"),
               ("cylinder", "Round", "All that is nearer to the hinge than a certain distance goes to one part"),
               ("exact", "Least", "Only what would be in the way goes to the other part. Joints of several axes are made round all the same")))
    seams: StringProperty(
        name="Seams", options={"HIDDEN"}, description="Where parts meet on the target, in its own space, as JSON text")
    division: PointerProperty(
        type=bpy.types.Mesh, name="Division", options={"HIDDEN"}, description="The target's surface with the part that each place belongs to")
    show_seams: BoolProperty(name="Show Seams", default=True, description="Draw the lines where parts meet on the target in the 3D view")
    active_edit: IntProperty(name="Active Wish", options={"HIDDEN"})
    stored: StringProperty(
        name="Parts", options={"HIDDEN"}, description="Each bone's share of the target, as JSON text")
    stored_for: StringProperty(options={"HIDDEN"})


CLASSES = (TransformablesEdit, TransformablesSegmentationSettings)
