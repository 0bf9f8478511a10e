"""Render a finished design: character mode, half folded, object mode (and steps between, or a turntable).

    blender -b DESIGN.blend --python scripts/render_design.py -- OUT_DIR [--frames N] [--size W H]

Writes OUT_DIR/00.png (character mode) to OUT_DIR/NN.png (object mode). Each part has a colour of its own. Reads only the
roles that the design's objects carry, so it needs no add-on.
"""
import argparse
import colorsys
import os
import sys

import bpy
from mathutils import Vector
import numpy as np

MARGIN = 1.08


def by_role(role):
    return [o for o in bpy.data.objects if o.get("transformable_role") == role]


def colour_parts(parts):
    for index, part in enumerate(sorted(parts, key=lambda o: o["transformable_bone"])):
        hue = (index * 0.381966) % 1.0  # golden ratio: neighbours in the list differ most
        part.color = (*colorsys.hsv_to_rgb(hue, 0.55, 0.9), 1.0)


def points_over(scene, parts, frames):
    """All corners of all parts at the given frames, n x 3."""
    points = []
    for frame in frames:
        scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for part in parts:
            world = np.array(part.evaluated_get(depsgraph).matrix_world)
            corners = np.empty(3 * len(part.data.vertices), np.float32)
            part.data.vertices.foreach_get("co", corners)
            points.append(corners.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3])
    return np.concatenate(points)


def place_camera(scene, points):
    """One view for all pictures, as near as lets all points be seen."""
    data = bpy.data.cameras.new("transformables_camera")
    camera = bpy.data.objects.new("transformables_camera", data)
    scene.collection.objects.link(camera)
    data.type = "ORTHO"
    turn = Vector((-1.0, 1.6, -0.9)).to_track_quat("-Z", "Y")
    seen = points @ np.array(turn.to_matrix())  # right, up and towards the camera
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, depth = high - low
    camera.location = turn @ Vector((*(low + high)[:2] / 2, high[2] + 0.1 * depth))
    camera.rotation_euler = turn.to_euler()
    aspect = scene.render.resolution_x / scene.render.resolution_y
    data.ortho_scale = MARGIN * max(width, height * aspect)
    data.clip_start, data.clip_end = 0.01 * depth, 1.5 * depth
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
    for name in dir(scene.render):  # what Blender would write into the pictures: the file's path, its host and such
        if name.startswith("use_stamp_"):
            setattr(scene.render, name, False)
    shading = scene.display.shading
    shading.light, shading.color_type = "STUDIO", "OBJECT"
    shading.show_cavity, shading.show_shadows = True, True
    scene.world = scene.world or bpy.data.worlds.new("transformables_world")
    scene.world.color = (0.95, 0.95, 0.95)
    first, last = scene.frame_start, scene.frame_end
    frames = [round(first + (last - first) * i / (args.frames - 1)) for i in range(args.frames)]
    place_camera(scene, points_over(scene, parts, frames))
    for index, frame in enumerate(frames):
        scene.frame_set(frame)
        scene.render.filepath = os.path.join(os.path.abspath(args.out_dir), f"{index:02d}.png")
        bpy.ops.render.render(write_still=True)


main()
