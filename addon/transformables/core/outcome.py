# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run of the pipeline has come to, as the plain dict that goes back to Blender."""

EMBEDDING_FIELDS = ("root", "angles", "morphology", "terms", "value", "symmetric", "deepest_protrusion", "deepest_collision")


def of(run):
    """A finished run's result; what its last stage did not come to is None or empty."""
    character, target = run.character, run.target
    return {
        "until": run.until, "stopped": run.stopped, "options": run.options.as_dict(), "native_version": run.tn.version,
        "seconds": run.seconds, "warnings": run.warnings, "peak_memory_mb": _peak_memory_mb(),
        "character": {
            "names": list(run.armature["names"]), "parents": list(run.armature["parents"]),
            "bodies": list(character.names), "members": [list(m) for m in character.members],
            "body_parents": list(character.parents), "hinges": [[list(h) for h in hs] for hs in character.hinges],
            "first_angle": list(character.first_angle), "angle_count": character.angle_count,
            "mirrored": bool(character.mirrored), "scale": character.scale},
        "names": run.job.get("names", {}),
        "target": {**run.job.get("target", {}), "scale": target.scale, "centre": list(target.centre), "volume": target.volume,
                   "grid": list(target.grid), "mirror_axis": target.mirror_axis},
        "embedding": run.stored.get("embedding") or run.poses.solution(run.embedding), "solutions": run.solutions,
        "path": None if run.path is None else _path(run), "seams": run.seams, "finishing": None if run.parts is None else _parts(run)}


def embedding(native):
    """A native embedding's fields as plain values."""
    return {name: _plain(getattr(native, name)) for name in EMBEDDING_FIELDS}


def _path(run):
    moves, _, new_of = run.joined or (run.path.moves, None, range(len(run.path.moves)))
    return {"moves": [[list(turn) for turn in turns] for turns in moves], "overlap_volume": run.path.overlap_volume,
            "collisions": [{**c, "move": new_of[c["move"]], "angles": [turn[0] for turn in run.path.moves[c["move"]]]} for c in run.path.collisions]}


def _parts(run):
    parts = run.parts
    return {"parts": [{"bone": part["bone"], "volume": part["volume"]} for part in parts.parts],
            "preview": run.until != "finishing", "collisions": [dict(c) for c in parts.collisions],
            "minimum_clearance": parts.minimum_clearance, "pinned": list(parts.pinned),
            "carved_volume_pct": parts.carved_volume_pct, "filled_volume_pct": parts.filled_volume_pct,
            "certificate": None if run.certificate is None else _certificate(run)}


def _certificate(run):
    gap = min((row[-1] for row in run.joined[1]), default=run.certificate.gap) if run.joined else run.certificate.gap
    return {"holds": run.certificate.holds, "gap": gap, "open": [dict(place) for place in run.certificate.open]}


def _plain(value):
    if isinstance(value, dict):
        return dict(value)
    if isinstance(value, (bool, int, float)):
        return value
    return list(value)


def _peak_memory_mb():
    try:
        import resource
    except ImportError:  # Windows
        return None
    import sys
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024 * 1024 if sys.platform == "darwin" else 1024)
