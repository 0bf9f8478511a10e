# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's edits of the segmentation, from the scene's list into a job."""
import numpy as np

from ..core.options import UserError
from . import mesh

OF_A_BONE = ("remove", "inhibit", "assign")
PAINTED = ("keep_whole", "assign")


def gather(edits, context, target_obj):
    """Rows for a job's message (core/pipeline.py) and the arrays that they name.

    `edits`: objects with kind, bone, group, thickness_mm, label(). Raises UserError when one names no bone or no vertex group. A
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
        rows.append(row)
    return rows, arrays


def _named(edit, name, what):
    if not name:
        raise UserError(f"The edit '{edit.label()}' names no {what}: pick one, or switch the edit off")
    return name
