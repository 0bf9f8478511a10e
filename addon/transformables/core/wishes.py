# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's wishes for the parts, as a job has them (core/pipeline.py: `edits`), made ready for the native module."""

GIVES = {"bone_gives": "to_parent", "parent_gives": "to_child"}   # told to transfer; all others are replayed on the parts


def edits(native, target, options, body_names, wanted, read):
    """Those that are replayed, in order. `body_names` has, for a bone, the name of the body that it is part of (bones that are fixed to their
    parents have no part of their own); `read(name)` gives an array's bytes."""
    return [_edit(native, target, options, body_names, edit, read) for edit in wanted if edit["kind"] not in GIVES]


def _edit(native, target, options, body_names, edit, read):
    painted, start, end = (read(edit[key]) if key in edit else b"" for key in ("faces", "from", "to"))
    bone, other = (body_names.get(edit.get(key, ""), edit.get(key, "")) for key in ("bone", "other"))
    return native.make_edit(target, kind=edit["kind"], bone=bone, other=other, name=edit.get("name", ""),
                            reach=options.target_units(edit.get("thickness_mm", 0.0)),
                            painted=painted, from_points=start, to_points=end)


def directions(wanted, bodies, parents):
    """Of a body's joint with its parent, which of the two gives material to the other; and warnings. `bodies`: of each bone's name, which body it is part of."""
    found, warnings = {}, []
    for edit in wanted:
        if edit["kind"] not in GIVES:
            continue
        body = bodies.get(edit["bone"])
        if body is None or parents[body] < 0:
            warnings.append(f"Which part gives room at the joint of '{edit['bone']}' was left out: this character has no such joint")
        else:
            found[body] = GIVES[edit["kind"]]
    return found, warnings
