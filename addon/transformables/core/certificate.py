# SPDX-License-Identifier: GPL-3.0-or-later
"""The certificate as a file that can be replayed by itself: bones, path, part meshes, and the intervals with their bounds.

All lengths are in target units (the target's longest side is 0.5). Parts are in their bone's frame; vertices are single-precision numbers
and triangles 32-bit integers, little-endian, in base64. An interval is (move, bone, bone, from, to, bound): over that share of the move, hinges turning at
constant rates, the two parts are at least `bound` apart. tests/addon/check_certificate.py reads it.
"""
import base64
import json
import sys
from array import array

from .kinematics import matrix_of, multiply, transposed, turned

FORMAT = "transformables certificate 1"
INTERVAL_WIDTH = 6


def document(result, arrays):
    """A finished job's certificate, as plain JSON data."""
    finishing = result["finishing"]
    certificate = finishing["certificate"]
    return {"format": FORMAT, "holds": certificate["holds"], "gap": certificate["gap"], "open": certificate["open"],
            "angles": list(result["embedding"]["angles"]), "moves": result["path"]["moves"], "bodies": _bodies(result, arrays),
            "parts": [{"bone": part["bone"], "vertices": _encoded("f", _numbers(arrays, f"part_{index}_vertices")),
                       "triangles": _encoded("i", _numbers(arrays, f"part_{index}_triangles"))}
                      for index, part in enumerate(finishing["parts"])],
            "intervals": _intervals(_numbers(arrays, "certificate_intervals"))}


def write(path, made):
    with open(path, "w", encoding="utf-8") as out:
        json.dump(made, out, allow_nan=False)
        out.write("\n")


def _bodies(result, arrays):
    """Where each body's head is in its parent's frame, and how it is turned there at rest (three rows)."""
    character, morphology = result["character"], result["embedding"]["morphology"]
    heads, axes = _numbers(arrays, "heads"), _numbers(arrays, "axes")
    bodies = []
    for body, parent in enumerate(character["body_parents"]):
        lead = character["members"][body][0]
        row = {"name": character["bodies"][body], "parent": parent, "first_angle": character["first_angle"][body],
               "hinges": [hinge[0] for hinge in character["hinges"][body]]}
        if parent >= 0:
            above = character["members"][parent][0]
            to_parent = transposed(matrix_of(axes[9 * above:9 * above + 9]))
            offset = turned(to_parent, [a - b for a, b in zip(heads[3 * lead:3 * lead + 3], heads[3 * above:3 * above + 3])])
            row["head"] = [character["scale"] * morphology[parent] * x for x in offset]
            row["rest"] = [x for r in multiply(to_parent, matrix_of(axes[9 * lead:9 * lead + 9])) for x in r]
        bodies.append(row)
    return bodies


def _intervals(flat):
    rows = [list(flat[n:n + INTERVAL_WIDTH]) for n in range(0, len(flat), INTERVAL_WIDTH)]
    return [[int(move), int(a), int(b), *rest] for move, a, b, *rest in rows]


def _numbers(arrays, name):
    code, data = arrays[name]
    numbers = array(code)
    numbers.frombytes(bytes(data))
    return numbers


def _encoded(code, numbers):
    packed = array(code, numbers)
    if sys.byteorder == "big":
        packed.byteswap()
    return base64.b64encode(packed.tobytes()).decode("ascii")
