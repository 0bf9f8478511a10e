# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
import numpy as np

from ...ui import fingerprint, session, settings


def findings(obj, context):
    """What a target's mesh is like, in lines for the artist: size, and whether it is closed."""
    mesh = obj.evaluated_get(context.evaluated_depsgraph_get()).data
    size = " x ".join(f"{side:.3g}" for side in obj.dimensions)
    lines = [f"{len(mesh.polygons)} faces, {size} units"]
    edges = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    faces_an_edge = np.bincount(edges, minlength=len(mesh.edges))
    open_edges, crowded = int((faces_an_edge == 1).sum()), int((faces_an_edge > 2).sum())
    if open_edges:
        lines.append(f"{open_edges} open edges: holes will be closed")
    if crowded:
        lines.append(f"{crowded} edges with more than two faces: will be repaired")
    if not open_edges and not crowded:
        lines.append("Closed: every edge has two faces")
    return lines


class TRANSFORMABLES_OT_check_target(bpy.types.Operator):
    """Look at the target's mesh: its size, and whether it has holes. The mesh is not changed"""

    bl_idname = "transformables.check_target"
    bl_label = "Check Target"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        if settings.picked(context.scene, "target") is None:
            cls.poll_message_set("Pick the target: a mesh object of this scene")
            return False
        if session.current() is not None:
            cls.poll_message_set("A design is running: wait for it, or press Esc to cancel it")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        target = settings.picked(scene, "target")
        if target.mode == "EDIT":
            target.update_from_editmode()
        group = scene.transformables.target_stage
        if not target.data.polygons:
            self.report({"ERROR"}, f"'{target.name}' has no faces: pick a mesh that encloses some volume")
            return {"CANCELLED"}
        group.stored = "\n".join(findings(target, context))
        group.stored_for = fingerprint.take(scene, "target")
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_check_target,)
