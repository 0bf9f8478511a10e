# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished design's parts, out of Blender and into files for printing."""
import os
import tempfile

import numpy as np

from ..core import printing
from ..core.options import UserError

MM = "transformable_mm"  # of the rig: printed millimetres for a Blender unit
PINS = "transformable_pins"  # of the rig: how many joints have a pin; such parts hold together only when they are printed in their places


def parts_of(rig, assembled=False):
    """The parts of a rig as core/printing.py has them, each as it stands in its bone's own frame, or `assembled`, as the scene shows them now.

    @raises UserError
    """
    scale = rig.get(MM)
    if scale is None:
        raise UserError(f"'{rig.name}' was made by an older version, which did not write down its printed size: make the design again")
    parts = []
    for obj in sorted((o for o in rig.children if o.get("transformable_role") == "part"), key=lambda o: o["transformable_bone"]):
        data = obj.data
        data.calc_loop_triangles()
        vertices = np.empty(3 * len(data.vertices), np.float32)
        data.vertices.foreach_get("co", vertices)
        triangles = np.empty(3 * len(data.loop_triangles), np.int32)
        data.loop_triangles.foreach_get("vertices", triangles)
        if len(triangles):
            points = vertices.astype(np.float64).reshape(-1, 3)
            if assembled:
                frame = np.array(rig.matrix_world.inverted() @ obj.matrix_world)
                points = points @ frame[:3, :3].T + frame[:3, 3]
            parts.append((obj["transformable_bone"], (points * scale).tolist(), triangles.reshape(-1, 3).tolist()))
    if not parts:
        raise UserError(f"'{rig.name}' has no parts to print")
    whole = printing.onto_plate([point for _, points, _ in parts for point in points]) if assembled else None
    standing = [(name, printing.moved(points, whole or printing.onto_plate(points)), triangles) for name, points, triangles in parts]
    return [(name, points, printing.without_slivers(points, triangles)) for name, points, triangles in standing]


def export(rig, folder, file_format="stl"):
    """Writes a rig's parts into a folder, which is made when it is not there: an STL a part, or one 3MF, apart or assembled. Gives the files' names.

    All are written aside first, so that a full disk leaves no half of them. @raises UserError
    """
    assembled = file_format == "assembled"
    parts = parts_of(rig, assembled)
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".printing-") as aside:
            if file_format != "stl":
                names = printing.file_names([f"{rig.name} assembled" if assembled else rig.name], "3mf")
                printing.three_mf(os.path.join(aside, names[0]), parts, assembled)
            else:
                names = printing.file_names([name for name, _, _ in parts], "stl")
                for name, part in zip(names, parts):
                    printing.stl(os.path.join(aside, name), *part)
            for name in names:
                os.replace(os.path.join(aside, name), os.path.join(folder, name))
    except OSError as error:
        raise UserError(f"the parts can't be written to '{folder}' ({error.strerror}): choose a folder that you may write to") from error
    return names
