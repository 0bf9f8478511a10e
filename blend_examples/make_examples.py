"""Make the inputs of the eight designs of the paper's Table 1, from shapes that this script models itself.

    blender -b --factory-startup --python blend_examples/make_examples.py [-- NAME ...]

Each example is a .blend beside this script with one armature (hinges as IK locks and limits) and one closed mesh. The bone counts are
the paper's: spider 17, human 20, dog 19, snake 15. CarSpider1 and 2 share their inputs: they are two folds of the same pair.
"""
import math
import os
import sys

import bpy
from mathutils import Matrix, Vector

HERE = os.path.dirname(os.path.abspath(__file__))


# --- Targets: unions of simple solids, made one closed skin by Blender's voxel remesher -----------------------------------------

def ellipsoid(centre, radii, turn_x=0.0):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1.0)
    obj = bpy.context.object
    obj.matrix_world = Matrix.Translation(centre) @ Matrix.Rotation(turn_x, 4, "X") @ Matrix.Diagonal((*radii, 1.0))
    return obj


def cylinder(centre, radius, depth, axis):
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=radius, depth=depth)
    obj = bpy.context.object
    turn = {"X": Matrix.Rotation(math.pi / 2, 4, "Y"), "Y": Matrix.Rotation(math.pi / 2, 4, "X"), "Z": Matrix.Identity(4)}[axis]
    obj.matrix_world = Matrix.Translation(centre) @ turn
    return obj


def rounded_box(centre, size, bevel):
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    obj = bpy.context.object
    obj.matrix_world = Matrix.Translation(centre) @ Matrix.Diagonal((*size, 1.0))
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    modifier = obj.modifiers.new("bevel", "BEVEL")
    modifier.width, modifier.segments = bevel, 5
    return obj


def one_skin(name, solids, voxel, smooth=2):
    """Joins solids into one closed triangle mesh."""
    bpy.ops.object.select_all(action="DESELECT")
    for solid in solids:
        solid.select_set(True)
    bpy.context.view_layer.objects.active = solids[0]
    bpy.ops.object.convert(target="MESH")
    if len(solids) > 1:
        bpy.ops.object.join()
    obj = bpy.context.object
    obj.name = obj.data.name = name
    bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
    remesh = obj.modifiers.new("remesh", "REMESH")
    remesh.mode, remesh.voxel_size = "VOXEL", voxel
    if smooth:
        fair = obj.modifiers.new("fair", "SMOOTH")
        fair.factor, fair.iterations = 0.5, smooth
    obj.modifiers.new("triangles", "TRIANGULATE")
    bpy.ops.object.convert(target="MESH")
    return bpy.context.object


def car():
    solids = [rounded_box((0, 0, 0.30), (0.80, 2.0, 0.36), 0.14), ellipsoid((0, -0.05, 0.46), (0.36, 0.62, 0.36))]
    for x in (-0.36, 0.36):
        for y in (-0.62, 0.62):
            solids.append(cylinder((x, y, 0.2), 0.2, 0.16, "X"))
    return one_skin("car", solids, 0.03)


def egg():
    obj = ellipsoid((0, 0, 0), (0.41, 0.41, 0.5))
    bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
    for vertex in obj.data.vertices:  # blunt below, pointed above
        vertex.co.xy *= 1.0 - 0.22 * vertex.co.z
    return one_skin("egg", [obj], 0.025)


def oval():
    return one_skin("oval", [ellipsoid((0, 0, 0), (0.5, 0.5, 0.41))], 0.025)


def wheel():
    solids = [cylinder((0, 0, 0), 0.5, 0.50, "X"), cylinder((0, 0, 0), 0.28, 0.634, "X")]
    return one_skin("wheel", solids, 0.024, smooth=4)


def bunny():
    solids = [ellipsoid((0, 0.10, 0.42), (0.36, 0.46, 0.40)), ellipsoid((0, -0.34, 0.80), (0.24, 0.27, 0.24)),
              ellipsoid((0, 0.56, 0.42), (0.12, 0.12, 0.12)), ellipsoid((0, -0.30, 0.16), (0.28, 0.16, 0.15)),
              ellipsoid((0, 0.20, 0.14), (0.40, 0.34, 0.14))]
    for x in (-0.12, 0.12):
        solids.append(ellipsoid((x, -0.20, 1.10), (0.085, 0.10, 0.28), turn_x=-0.35))
    return one_skin("bunny", solids, 0.03, smooth=6)


# --- Characters: bones with one hinge each ---------------------------------------------------------------------------------------

class Rig:
    """An armature under construction: bones by head, tail and the world axis that their hinge turns about."""

    def __init__(self, name):
        self.data = bpy.data.armatures.new(name)
        self.object = bpy.data.objects.new(name, self.data)
        bpy.context.collection.objects.link(self.object)
        bpy.context.view_layer.objects.active = self.object
        bpy.ops.object.mode_set(mode="EDIT")
        self.limits = {}

    def bone(self, name, parent, head, tail, axis=None, low=-120, high=120):
        """Adds a bone; its hinge is its local X, laid along `axis` (made square to the bone)."""
        bone = self.data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        if parent:
            bone.parent = self.data.edit_bones[parent]
        if axis is not None:
            along = (Vector(tail) - Vector(head)).normalized()
            across = (Vector(axis) - along * Vector(axis).dot(along)).normalized()
            bone.align_roll(across.cross(along))
            self.limits[name] = (low, high)
        return name

    def finish(self):
        bpy.ops.object.mode_set(mode="OBJECT")
        for name, (low, high) in self.limits.items():
            bone = self.object.pose.bones[name]
            bone.lock_ik_x, bone.lock_ik_y, bone.lock_ik_z = False, True, True
            bone.use_ik_limit_x = True
            bone.ik_min_x, bone.ik_max_x = math.radians(low), math.radians(high)
        return self.object


def spider():
    rig = Rig("spider")
    rig.bone("body", None, (0, -0.75, 0.5), (0, 0.75, 0.5))
    for side, sign in (("L", 1), ("R", -1)):
        for index, angle in enumerate((-60, -20, 20, 60)):
            out = Vector((sign * math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0))
            hip = Vector((sign * 0.18, 0.5 * (index - 1.5), 0.5))
            knee, foot = hip + 0.5 * out + Vector((0, 0, 0.25)), hip + 1.1 * out - Vector((0, 0, 0.4))
            axis = out.cross(Vector((0, 0, 1)))
            rig.bone(f"upper{index + 1}.{side}", "body", hip, knee, axis, -110, 110)
            rig.bone(f"lower{index + 1}.{side}", f"upper{index + 1}.{side}", knee, foot, axis, -150, 150)
    return rig.finish()


def human():
    x, y = (1, 0, 0), (0, 1, 0)
    rig = Rig("human")
    rig.bone("pelvis", None, (0, 0, 0.95), (0, 0, 1.1))
    rig.bone("spine", "pelvis", (0, 0, 1.1), (0, 0, 1.28), x, -90, 90)
    rig.bone("chest", "spine", (0, 0, 1.28), (0, 0, 1.48), x, -90, 90)
    rig.bone("head", "chest", (0, 0, 1.5), (0, 0, 1.78), x, -90, 90)
    for side, s in (("L", 1), ("R", -1)):
        rig.bone(f"shoulder.{side}", "chest", (0.04 * s, 0, 1.44), (0.18 * s, 0, 1.44), y, -60, 60)
        rig.bone(f"upper_arm.{side}", f"shoulder.{side}", (0.18 * s, 0, 1.44), (0.46 * s, 0, 1.42), y, -120, 120)
        rig.bone(f"forearm.{side}", f"upper_arm.{side}", (0.46 * s, 0, 1.42), (0.72 * s, 0, 1.42), (0, 0, 1), -150, 150)
        rig.bone(f"hand.{side}", f"forearm.{side}", (0.72 * s, 0, 1.42), (0.9 * s, 0, 1.42), y, -90, 90)
        rig.bone(f"hip.{side}", "pelvis", (0.03 * s, 0, 0.95), (0.12 * s, 0, 0.93), y, -60, 60)
        rig.bone(f"thigh.{side}", f"hip.{side}", (0.12 * s, 0, 0.93), (0.12 * s, 0, 0.5), x, -150, 150)
        rig.bone(f"shin.{side}", f"thigh.{side}", (0.12 * s, 0, 0.5), (0.12 * s, 0, 0.08), x, -150, 150)
        rig.bone(f"foot.{side}", f"shin.{side}", (0.12 * s, 0, 0.08), (0.12 * s, -0.2, 0.02), x, -90, 90)
    return rig.finish()


def dog():
    x = (1, 0, 0)
    rig = Rig("dog")
    rig.bone("hips", None, (0, 0.35, 0.62), (0, 0.1, 0.64))
    rig.bone("chest", "hips", (0, 0.1, 0.64), (0, -0.3, 0.64), x, -90, 90)
    rig.bone("neck", "chest", (0, -0.32, 0.68), (0, -0.48, 0.86), x, -120, 120)
    rig.bone("head", "neck", (0, -0.48, 0.86), (0, -0.74, 0.84), x, -120, 120)
    rig.bone("jaw", "head", (0, -0.52, 0.8), (0, -0.7, 0.76), x, -60, 60)
    rig.bone("tail1", "hips", (0, 0.38, 0.66), (0, 0.56, 0.74), x, -120, 120)
    rig.bone("tail2", "tail1", (0, 0.56, 0.74), (0, 0.74, 0.86), x, -120, 120)
    for side, s in (("L", 1), ("R", -1)):
        for end, parent, at in (("fore", "chest", -0.26), ("hind", "hips", 0.32)):
            bend = 0.06 if end == "fore" else -0.06
            rig.bone(f"{end}_upper.{side}", parent, (0.13 * s, at, 0.56), (0.14 * s, at + bend, 0.32), x, -120, 120)
            rig.bone(f"{end}_lower.{side}", f"{end}_upper.{side}", (0.14 * s, at + bend, 0.32), (0.14 * s, at, 0.08), x, -150, 150)
            rig.bone(f"{end}_foot.{side}", f"{end}_lower.{side}", (0.14 * s, at, 0.08), (0.14 * s, at - 0.12, 0.02), x, -90, 90)
    return rig.finish()


def snake():
    rig = Rig("snake")
    count, length = 15, 0.16
    for index in range(count):
        start = (0, length * (index - count / 2), 0.1)
        end = (0, length * (index + 1 - count / 2), 0.1)
        axis = ((0, 0, 1), (1, 0, 0))[index % 2]
        rig.bone(f"link{index + 1:02d}", f"link{index:02d}" if index else None, start, end, axis if index else None, -110, 110)
    return rig.finish()


EXAMPLES = {
    "car_spider_1": (car, spider), "car_spider_2": (car, spider), "wheel_spider": (wheel, spider), "egg_human": (egg, human),
    "egg_spider": (egg, spider), "oval_dog": (oval, dog), "bunny_snake": (bunny, snake), "bunny_human": (bunny, human),
}


def make(name):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    target, character = EXAMPLES[name]
    mesh = target().data
    armature = character()
    armature.location = (0, -3, 0)
    bpy.context.view_layer.update()
    bpy.data.orphans_purge(do_recursive=True)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(HERE, name + ".blend"), compress=True)
    print(f"{name}: {len(armature.data.bones)} bones, {len(mesh.polygons)} triangles")


def main():
    names = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    unknown = [n for n in names if n not in EXAMPLES]
    if unknown:
        sys.exit(f"make_examples: no example is called {', '.join(unknown)}; there are {', '.join(EXAMPLES)}")
    for name in names or EXAMPLES:
        make(name)


main()
