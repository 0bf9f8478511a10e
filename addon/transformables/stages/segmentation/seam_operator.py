# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves a seam over the target's surface: by a given displacement, or dragged with the mouse."""
import json

import bpy
import numpy as np
from bpy.props import FloatProperty, FloatVectorProperty, IntProperty
from bpy_extras import view3d_utils
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...bridge import division, mesh
from ...core import seams as curves
from ...core.division import Dragged
from ...ui import seam_overlay, session, settings

PICKED_WITHIN_PIXELS = 24
FIRST_SIZE = 0.15      # of the target's longest side: the fall-off a drag begins with
LEAST_PULL = 1e-3      # of the fall-off's size
LARGER, SMALLER = ("WHEELDOWNMOUSE", "PAGE_UP"), ("WHEELUPMOUSE", "PAGE_DOWN")  # Blender's own for proportional editing
WHEEL = 1.15           # what a turn of the wheel or a key does to it
HOLDING = 8            # points beside the moved ones that say that the seam stays there


class TRANSFORMABLES_OT_move_seam(bpy.types.Operator):
    """Drag the line between two parts over the target: press on a seam, and release where it is to be. The wheel, or Page Up and Page Down, change how much of the seam follows; Esc or a right click leaves all as it was"""

    bl_idname = "transformables.move_seam"
    bl_label = "Drag Seam"
    bl_options = {"UNDO"}

    seam: IntProperty(name="Seam", default=0, min=0, options={"SKIP_SAVE"}, description="Which of the seams, in the order in which they were found")
    point: IntProperty(name="Point", default=0, min=0, options={"SKIP_SAVE"}, description="Which of the seam's points is pulled")
    displacement: FloatVectorProperty(name="Displacement", size=3, subtype="XYZ", options={"SKIP_SAVE"},
                                      description="Where it is pulled to, from where it is, in the target's own space")
    size: FloatProperty(name="Size", default=0, min=0, options={"SKIP_SAVE"},
                        description="How far along the seam other points follow, in the target's own space; 0: some of the target's size")

    @classmethod
    def poll(cls, context):
        stage = context.scene.transformables.segmentation_stage
        if session.current() is not None and not session.current().gives_way:
            cls.poll_message_set("A design is running already: wait for it, or press Esc to cancel it")
            return False
        if settings.picked(context.scene, "target") is None or stage.division is None or not json.loads(stage.seams or "[]"):
            cls.poll_message_set("Divide the target into parts first")
            return False
        return True

    def execute(self, context):
        self._prepare(context)
        if self.seam >= len(self._seams) or self.point >= len(self._seams[self.seam]["points"]):
            self.report({"ERROR"}, f"There is no point {self.point} of a seam {self.seam}: choose from {len(self._seams)} seams")
            return {"CANCELLED"}
        if Vector(self.displacement).length < LEAST_PULL * self.size:
            return {"CANCELLED"}  # a click
        self._keep(context, self._moved())
        return {"FINISHED"}

    def invoke(self, context, event):
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Drag seams in a 3D view")
            return {"CANCELLED"}
        self._prepare(context)
        self._dragging = False
        self._frame = context.scene.frame_current
        context.scene.frame_set(context.scene.frame_end)  # parts that are there stand in object mode, under their seams
        self._tell(context, "Press on a seam and drag it   (Esc: cancel)")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in ("ESC", "RIGHTMOUSE") and event.value == "PRESS":
            return self._end(context, {"CANCELLED"})  # the frame goes back, too
        if event.type == "LEFTMOUSE" and event.value == "PRESS" and not self._dragging:
            self._dragging = self._pick(context, event)
            if not self._dragging:
                self._tell(context, "There is no seam here: press on one   (Esc: cancel)")
            return {"RUNNING_MODAL"}
        if not self._dragging:
            return {"PASS_THROUGH"}
        if event.type in (*LARGER, *SMALLER):
            if event.value == "PRESS":
                self.size *= WHEEL if event.type in LARGER else 1 / WHEEL
                self._show(context)
        elif event.type == "MOUSEMOVE":
            self._follow(context, event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._follow(context, event)
            return self._end(context, self.execute(context))
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        self._end(context, {"CANCELLED"})

    def _prepare(self, context):
        self._interrupted = session.current() is not None  # parts that settle still after the drag before this one
        session.end()
        target, stage = settings.picked(context.scene, "target"), context.scene.transformables.segmentation_stage
        self._seams = json.loads(stage.seams)
        vertices, triangles = mesh.read_triangles(context, target)
        self._world = target.matrix_world.copy()  # of a hidden object it is brought up to date by reading
        into = np.array(self._world.inverted_safe())
        own = vertices @ into[:3, :3].T + into[:3, 3]
        self._surface = BVHTree.FromPolygons(own.tolist(), triangles.tolist(), all_triangles=True)
        if self.size == 0:
            self.size = FIRST_SIZE * max(max(c[a] for c in target.bound_box) - min(c[a] for c in target.bound_box) for a in range(3))

    def _points(self):
        return [tuple(p) for p in self._seams[self.seam]["points"]]

    def _moved(self):
        return curves.pulled(self._points(), self._seams[self.seam]["closed"], self.point, tuple(self.displacement), self.size, self._snap)

    def _snap(self, point):
        return tuple(self._surface.find_nearest(point)[0])

    def _keep(self, context, moved):
        """Adds the wish, and shows the seam and the division as they are to be; the parts follow in a job of their own."""
        stage, points = context.scene.transformables.segmentation_stage, self._points()
        kept = curves.worth_sending(points, moved, HOLDING)
        edit = stage.edits.add()
        edit.kind = "move_seam"
        edit.bone, edit.other = self._seams[self.seam]["bones"]
        edit.points = json.dumps({"from": [points[i] for i in kept], "to": [[round(x, 6) for x in moved[i]] for i in kept]})
        stage.active_edit = len(stage.edits) - 1
        self._take_division(stage)
        division.keep_dragged(stage.division, self._division.moved(moved))
        self._seams[self.seam]["points"] = [[round(x, 6) for x in p] for p in moved]
        stage.seams = json.dumps(self._seams)

    def _take_division(self, stage):
        """Reads the division that the seam is part of, ready for the seam to move."""
        vertices, triangles, parts = division.read(stage.division)
        self._drawn = seam_overlay.Surface(vertices, triangles)
        seam = self._seams[self.seam]
        pair = [division.body(stage.division, name) for name in seam["bones"]]
        spacing = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).max()
        self._division = Dragged(vertices, self._drawn.normals, parts, pair, seam["points"], seam["closed"], spacing)

    def _pick(self, context, event):
        """Takes the seam's point nearest to the mouse; of those near, one that the target does not hide."""
        region, view, mouse = _in_view(context, event)
        origin = self._world.inverted_safe() @ view3d_utils.region_2d_to_origin_3d(region, view, mouse)
        near = []
        for seam_index, seam in enumerate(self._seams):
            for point_index, point in enumerate(seam["points"]):
                place = view3d_utils.location_3d_to_region_2d(region, view, self._world @ Vector(point))
                if place is not None and (place - mouse).length < PICKED_WITHIN_PIXELS:
                    near.append((self._hidden(origin, Vector(point)), (place - mouse).length, seam_index, point_index))
        if not near:
            return False
        _, _, self.seam, self.point = min(near)
        self.displacement = (0, 0, 0)
        self._take_division(context.scene.transformables.segmentation_stage)
        self._show(context)
        return True

    def _hidden(self, origin, point):
        way = point - origin
        hit = self._surface.ray_cast(origin, way.normalized(), way.length)
        return hit[0] is not None and (hit[0] - point).length > 0.02 * way.length

    def _follow(self, context, event):
        region, view, mouse = _in_view(context, event)
        into = self._world.inverted_safe()
        origin = into @ view3d_utils.region_2d_to_origin_3d(region, view, mouse)
        direction = (into.to_3x3() @ view3d_utils.region_2d_to_vector_3d(region, view, mouse)).normalized()
        hit = self._surface.ray_cast(origin, direction)[0]
        if hit is not None:  # beside the target the seam waits
            self.displacement = hit - Vector(self._points()[self.point])
            self._show(context)

    def _show(self, context):
        moved, closed = self._moved(), self._seams[self.seam]["closed"]
        seam_overlay.show_dragged(moved + moved[:1] if closed else moved, self._drawn, self._division.moved(moved))
        bones = self._seams[self.seam]["bones"]
        self._tell(context, f"Seam between {bones[0]} and {bones[1]}   size {self.size:.3g} (wheel, Page Up/Down)   (release: keep, Esc: cancel)")
        session.redraw()

    def _tell(self, context, text):
        context.workspace.status_text_set(text)

    def _end(self, context, outcome):
        seam_overlay.show_dragged(())
        if outcome == {"CANCELLED"}:
            context.scene.frame_set(self._frame)
        context.workspace.status_text_set(None)
        session.redraw()
        if outcome == {"FINISHED"} or self._interrupted:
            _settle_soon(context.scene.name)
        return outcome


def _settle_soon(scene):
    """Starts the job that lets the parts follow, once the drag's own undo step is made."""
    def begin():
        window = next((w for w in bpy.context.window_manager.windows if w.scene.name == scene), None)
        if window is not None:
            with bpy.context.temp_override(window=window):
                if bpy.ops.transformables.settle_seams.poll():
                    bpy.ops.transformables.settle_seams("INVOKE_DEFAULT")
    bpy.app.timers.register(begin, first_interval=0)


def _in_view(context, event):
    """The 3D view's own region, its view and the mouse in it: a drag that a panel's button has begun has the panel's region."""
    region = next(r for r in context.area.regions if r.type == "WINDOW")
    return region, context.area.spaces.active.region_3d, Vector((event.mouse_x - region.x, event.mouse_y - region.y))


CLASSES = (TRANSFORMABLES_OT_move_seam,)
