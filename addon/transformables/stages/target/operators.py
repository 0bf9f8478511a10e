# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
import numpy as np

from ...core.options import UserError
from ...ui.check_operator import CheckOperator


class TRANSFORMABLES_OT_check_target(CheckOperator, bpy.types.Operator):
    """Look at the target's mesh: its size, and whether it has holes. The mesh is not changed"""

    bl_idname = "transformables.check_target"
    bl_label = "Check Target"
    stage = "target"
    to_pick = "Pick the target: a mesh object of this scene"

    def findings(self, context, obj):
        if obj.mode == "EDIT":
            obj.update_from_editmode()
        if not obj.data.polygons:
            raise UserError(f"'{obj.name}' has no faces: pick a mesh that encloses some volume")
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


CLASSES = (TRANSFORMABLES_OT_check_target,)
