# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a design, as CONTRACT.md lays it down: plain JSON from a job's result."""
import json
import math

from .options import LONGEST_SIDE, DesignOptions

LETTERS = "XYZ"


def build(result, schedule, version, blender, in_the_way=()):
    """The report as a dict. `schedule` is that of the fold's action; `in_the_way` the rows of core/blocks.py."""
    options = DesignOptions(**result["options"])
    character, embedding, finishing = result["character"], result["embedding"], result["finishing"]
    collisions = _collisions(result, schedule, options) if finishing else []
    terms = dict(embedding["terms"])
    finished = bool(finishing) and not finishing["preview"]
    certificate = finishing["certificate"] if finished else None
    holds = bool(certificate) and certificate["holds"]
    return _finite({
        "version": version, "blender": blender, "native_version": result["native_version"],
        "seconds": dict(result["seconds"]),
        "bones": len({bone for members in character["members"] for bone in members}),
        "bodies": len(character["bodies"]), "parts": len(finishing["parts"]) if finishing else 0,
        "grid": list(result["target"]["grid"]), "resolution": options.resolution, "seed": options.seed,
        "options": result["options"], "symmetric": embedding["symmetric"],
        "objective": {**terms, "weighted_sum": terms.get("total")},
        # Proved for every time of the motion, for the meshes as they are (native/finishing/certificate.h); where there is no proof, the
        # clearance is what samples show.
        "certified": holds and not collisions,
        "minimum_clearance_mm": options.millimetres(certificate["gap"] if holds else finishing["minimum_clearance"]) if finished else None,
        "collisions": collisions,
        "in_the_way": [{key: row[key] for key in ("bones", "state", "frame", "volume_mm3", "joints")} for row in in_the_way],
        "uncertified": _uncertified(result, schedule, options, certificate) if certificate else [],
        "carved_volume_pct": finishing["carved_volume_pct"] if finished else None,
        "filled_volume_pct": finishing["filled_volume_pct"] if finished else None,
        "pinned_joints": [character["bodies"][bone] for bone in finishing["pinned"]] if finished else None,
        "folding_order": folding_order(result, schedule),
        "frames": [1, schedule.last_frame],
        "fit_scale": character["scale"] / result["target"]["scale"],
        "proportions": dict(zip(character["bodies"], embedding["morphology"])),
        "peak_memory_mb": result["peak_memory_mb"],
        "warnings": list(result["warnings"])})


def folding_order(result, schedule):
    """Every turn in the order of the fold: bone, axis, angles in degrees, frames; turns of one move share its frames."""
    owners = _owners(result["character"])
    return [{"bone": owners[angle][0], "axis": owners[angle][1], "from_deg": math.degrees(start), "to_deg": math.degrees(end),
             "frames": [step.start, step.end]}
            for step in schedule.steps for angle, start, end in step.turns]


def collision_line(collision):
    """One collision in words."""
    turning = ", ".join(f"{a['bone']} at {a['angle_deg']:.0f} degrees" for a in collision["angles"])
    return (f"'{collision['bones'][0]}' and '{collision['bones'][1]}' meet at frame {collision['frame']:g} ({turning}): "
            f"{collision['volume_mm3']:.3g} mm3")


def uncertified_line(place):
    """One place without proof in words."""
    what = {"touching": "touch", "inside": "lie within each other", "unresolved": "could not be shown to stay apart"}[place["reason"]]
    return f"'{place['bones'][0]}' and '{place['bones'][1]}' {what} at frame {place['frame']:g}"


def write(path, report):
    with open(path, "w", encoding="utf-8") as out:
        json.dump(report, out, indent=1, allow_nan=False)
        out.write("\n")


def moment(result, schedule, move, fraction):
    """(frame, joints) of a share of a move: joints [{bone, axis, angle (its index), angle_deg}] are those that turn."""
    step = next((s for s in schedule.steps if s.move == move), None)
    frame = schedule.frame_of(move, fraction) if step else float(schedule.last_frame)
    angles, owners = schedule.angles_at(frame, result["character"]["angle_count"]), _owners(result["character"])
    return round(frame, 3), [{"bone": owners[a][0], "axis": owners[a][1], "angle": a, "angle_deg": math.degrees(angles[a])}
                             for a, _, _ in (step.turns if step else [])]


def _uncertified(result, schedule, options, certificate):
    bodies = result["character"]["bodies"]
    return [{"bones": [bodies[place["bone_a"]], bodies[place["bone_b"]]], "frame": moment(result, schedule, place["move"], place["fraction"])[0],
             "distance_mm": options.millimetres(place["distance"]), "reason": place["reason"]} for place in certificate["open"]]


def _collisions(result, schedule, options):
    bodies = result["character"]["bodies"]
    cubic = (options.size_mm / LONGEST_SIDE) ** 3
    rows = []
    for collision in result["finishing"]["collisions"]:
        frame, joints = moment(result, schedule, collision["move"], collision["fraction"])
        rows.append({"bones": [bodies[collision["bone_a"]], bodies[collision["bone_b"]]], "frame": frame,
                     "volume_mm3": collision["volume"] * cubic,
                     "angles": [{key: joint[key] for key in ("bone", "axis", "angle_deg")} for joint in joints]})
    return rows


def _owners(character):
    """(bone, axis letter) of every angle."""
    owners = {}
    for body, first, hinges in zip(character["bodies"], character["first_angle"], character["hinges"]):
        for offset, (axis, _, _) in enumerate(hinges):
            owners[first + offset] = (body, LETTERS[axis])
    return owners


def _finite(value):
    """JSON knows no NaN and no infinity: null instead."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
