"""Render a finished design: character mode, half folded, object mode (and steps between, or a turntable).

    blender -b DESIGN.blend --python scripts/render_design.py -- OUT_DIR [--frames N] [--size W H]

Writes OUT_DIR/00.png (character mode) to OUT_DIR/NN.png (object mode). Each part has a colour of its own. Reads only the
roles that the design's objects carry, so it needs no add-on.
"""
import argparse
import colorsys
import math
import os
import sys

import bpy
from mathutils import Vector


def by_role(role):
    return [o for o in bpy.data.objects if o.get("transformable_role") == role]


def colour_parts(parts):
    for index, part in enumerate(sorted(parts, key=lambda o: o["transformable_bone"])):
        hue = (index * 0.381966) % 1.0  # golden ratio: neighbours in the list differ most
        part.color = (*colorsys.hsv_to_rgb(hue, 0.55, 0.9), 1.0)


def bounds_over(scene, parts, frames):
    """Corners of the box around all parts at the given frames."""
    low, high = Vector((math.inf,) * 3), Vector((-math.inf,) * 3)
    for frame in frames:
        scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for part in parts:
            matrix = part.evaluated_get(depsgraph).matrix_world
            for corner in part.bound_box:
                p = matrix @ Vector(corner)
                low = Vector(map(min, low, p))
                high = Vector(map(max, high, p))
    return low, high


def place_camera(scene, low, high):
    data = bpy.data.cameras.new("transformables_camera")
    camera = bpy.data.objects.new("transformables_camera", data)
    scene.collection.objects.link(camera)
    data.type = "ORTHO"
    direction = Vector((1.0, -1.6, 0.9)).normalized()
    centre, radius = (low + high) / 2, (high - low).length / 2
    camera.location = centre + direction * radius * 4
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    inverse = camera.matrix_basis.inverted()
    corners = [inverse @ Vector((x, y, z)) for x in (low.x, high.x) for y in (low.y, high.y) for z in (low.z, high.z)]
    width = 2 * max(abs(c.x) for c in corners)
    height = 2 * max(abs(c.y) for c in corners)
    aspect = scene.render.resolution_x / scene.render.resolution_y
    data.ortho_scale = 1.08 * max(width, height * aspect)
    data.clip_end = radius * 10
    scene.camera = camera


def main():
    parser = argparse.ArgumentParser(prog="render_design.py")
    parser.add_argument("out_dir")
    parser.add_argument("--frames", type=int, default=3, help="pictures, from character mode to object mode")
    parser.add_argument("--size", type=int, nargs=2, default=(960, 720))
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    scene = bpy.context.scene
    parts = by_role("part")
    if not parts:
        sys.exit("render_design: no object has transformable_role = 'part'; open a finished design")
    os.makedirs(args.out_dir, exist_ok=True)
    colour_parts(parts)
    for obj in bpy.data.objects:
        obj.hide_render = obj not in parts
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x, scene.render.resolution_y = args.size
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
    shading = scene.display.shading
    shading.light, shading.color_type = "STUDIO", "OBJECT"
    shading.show_cavity, shading.show_shadows = True, True
    scene.world = scene.world or bpy.data.worlds.new("transformables_world")
    scene.world.color = (0.95, 0.95, 0.95)
    first, last = scene.frame_start, scene.frame_end
    frames = [round(first + (last - first) * i / (args.frames - 1)) for i in range(args.frames)]
    place_camera(scene, *bounds_over(scene, parts, frames))
    for index, frame in enumerate(frames):
        scene.frame_set(frame)
        scene.render.filepath = os.path.join(os.path.abspath(args.out_dir), f"{index:02d}.png")
        bpy.ops.render.render(write_still=True)


main()
