# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's edits of the segmentation, from the scene's list into a job; and seams, from a result to the scene."""
import json

import numpy as np

from ..core.options import UserError
from . import mesh

OF_A_BONE = ("remove", "inhibit", "assign", "bone_gives", "parent_gives")
PAINTED = ("keep_whole", "assign")


def gather(edits, context, target_obj):
    """Rows for a job's message (core/pipeline.py) and the arrays that they name.

    `edits`: objects with kind, bone, other, group, thickness_mm, points, label(). Raises UserError when one names no bone or no vertex group. A
    group that is not there any more gives a row without faces, which the worker tells the artist of.
    """
    rows, arrays = [], {}
    for index, edit in enumerate(edits):
        row = {"kind": edit.kind}
        if edit.kind in OF_A_BONE:
            row["bone"] = _named(edit, edit.bone, "bone")
        if edit.kind == "inhibit":
            row["thickness_mm"] = round(edit.thickness_mm, 4)
        if edit.kind in PAINTED:
            row["name"] = _named(edit, edit.group, "vertex group of the target")
            corners = mesh.read_group(context, target_obj, edit.group)
            row["faces"] = f"edit_{index}_faces"
            arrays[row["faces"]] = ("d", (np.empty((0, 3, 3)) if corners is None else corners).tobytes())
        if edit.kind == "move_seam":
            if not edit.points:
                raise UserError(f"The edit '{edit.label()}' says nothing of where the seam is to be: drag the seam")
            row["bone"], row["other"] = edit.bone, edit.other
            for key, points in json.loads(edit.points).items():  # "from" and "to"
                row[key] = f"edit_{index}_{key}"
                arrays[row[key]] = ("d", _placed(points, target_obj.matrix_world).tobytes())
        rows.append(row)
    return rows, arrays


def seams_of(result, arrays, target_obj):
    """A result's seams as JSON text: a list of {bones, closed, points (n x 3)} in the target's own space, so that they go where it goes."""
    into = target_obj.matrix_world.inverted_safe()
    return json.dumps([{"bones": seam["bones"], "closed": seam["closed"],
                        "points": np.round(_placed(np.frombuffer(arrays[seam["points"]][1]).reshape(-1, 3), into), 6).tolist()}
                       for seam in result["seams"]])


def _placed(points, matrix):
    world = np.array(matrix, np.float64)
    return np.ascontiguousarray(np.reshape(points, (-1, 3)) @ world[:3, :3].T + world[:3, 3])


def _named(edit, name, what):
    if not name:
        raise UserError(f"The edit '{edit.label()}' names no {what}: pick one, or switch the edit off")
    return name
