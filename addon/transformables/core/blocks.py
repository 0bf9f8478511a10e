# SPDX-License-Identifier: GPL-3.0-or-later
"""Which pairs of parts are in each other's way on the fold, where, and what it costs: worst first, a row a pair.

A row is plain JSON: `bones` (two bodies' names), `state` (one of STATES), `frame` of the worst moment, `move` and `fraction` that it is in (None for a move of nothing), `volume_mm3` (what meets there; of what
was or will be carved, all along the path), `joints` [{bone, axis, angle (its index), angle_deg}] that turn at that moment, `place` (Blender units, in the
first bone's frame; None when it is not known), `radius` (Blender units: how large a ball of that volume is).
"""
import math

from .options import LONGEST_SIDE, DesignOptions
from .report import moment

# Still meet in the finished design; could not be proved to stay apart; will be carved; was carved.
STATES = MEETS, UNPROVED, TO_CARVE, CARVED = ("meets", "unproved", "to_carve", "carved")
LISTED = 20
LEAST_SHARE = 1e-4  # of the target's volume: what costs less is not listed
SMALLEST_RADIUS = 0.01  # target units, so that it can be seen


def blocks(result, schedule):
    """The rows of a job's result, `schedule` being that of its fold. Needs result["path"] and result["finishing"]."""
    if not result["path"] or not result["finishing"]:
        return []
    finished = not result["finishing"]["preview"]
    left = _left(result) if finished else {}
    costs = _costs(result, CARVED if finished else TO_CARVE)
    rows = sorted(left.values(), key=lambda row: (row["state"] != MEETS, -row["volume"]))
    rows += sorted((row for pair, row in costs.items() if pair not in left), key=lambda row: -row["volume"])
    return [_row(result, schedule, row) for row in rows[:LISTED]]


def share_of(path, pair, volume):
    """What carving would take from a pair of bodies, as a share of a volume; `path` as a result has it."""
    return sum(c["swept"] for c in path["collisions"] if {c["bone_a"], c["bone_b"]} == set(pair)) / volume


def volume_words(mm3):
    return f"{mm3 / 1000:.1f} cm³" if mm3 >= 1000 else f"{mm3:.0f} mm³" if mm3 >= 10 else f"{mm3:.1f} mm³"


def words(row):
    """One row in a sentence."""
    first, second = row["bones"]
    when = f"at frame {row['frame']:.0f}{_turning(row)}"
    volume = volume_words(row["volume_mm3"])
    if row["state"] == MEETS:
        return f"{first} and {second} still run into each other {when}: {volume}"
    if row["state"] == UNPROVED:
        return f"{first} and {second} could not be proved to stay apart {when}"
    if row["state"] == TO_CARVE:
        return f"{first} and {second} are in each other's way, most {when}: {volume} to carve"
    return f"{first} and {second} were in each other's way, most {when}: about {volume} carved"


def _turning(row):
    turning = ", ".join(f"{joint['bone']} at {joint['angle_deg']:.0f}°" for joint in row["joints"])
    return f" ({turning})" if turning else ""


def _pair(found):
    return min(found["bone_a"], found["bone_b"]), max(found["bone_a"], found["bone_b"])


def _left(result):
    """By pair: what is not proved, with the volume that samples show to meet."""
    rows = {}
    for found in result["finishing"]["collisions"]:  # worst first
        rows.setdefault(_pair(found), {**found, "state": MEETS})
    certificate = result["finishing"]["certificate"]
    for found in certificate["open"] if certificate else ():
        row = rows.setdefault(_pair(found), {**found, "state": UNPROVED, "volume": 0.0})
        if "place" in found and found["bone_a"] == row["bone_a"]:
            row.setdefault("place", found["place"])
    return rows


def _costs(result, state):
    """By pair: all that it costs along the path, at its worst moment."""
    rows = {}
    for found in result["path"]["collisions"]:
        row = rows.setdefault(_pair(found), {"state": state, "volume": 0.0, "swept": 0.0})
        row["volume"] += found["swept"]
        if found["swept"] > row["swept"]:
            row.update({key: found[key] for key in ("bone_a", "bone_b", "move", "fraction", "swept", "place", "angles") if key in found})
    least = LEAST_SHARE * result["target"]["volume"]
    return {pair: row for pair, row in rows.items() if row["volume"] > least}


def _row(result, schedule, found):
    options, unit = DesignOptions(**result["options"]), 1.0 / result["target"]["scale"]
    bodies = result["character"]["bodies"]
    frame, joints = moment(result, schedule, found["move"], found["fraction"])
    if "angles" in found:  # of a move that others were joined to, only the joints that this pair met by
        joints = [joint for joint in joints if joint["angle"] in found["angles"]]
    moves = any(step.move == found["move"] for step in schedule.steps)
    ball = (0.75 * found["volume"] / math.pi) ** (1 / 3)
    return {"bones": [bodies[found["bone_a"]], bodies[found["bone_b"]]], "state": found["state"], "frame": frame,
            "move": found["move"] if moves else None, "fraction": found["fraction"],
            "volume_mm3": found["volume"] * (options.size_mm / LONGEST_SIDE) ** 3, "joints": joints,
            "place": [x * unit for x in found["place"]] if "place" in found else None, "radius": max(ball, SMALLEST_RADIUS) * unit}
