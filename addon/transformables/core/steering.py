# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist fixes before a search, from bone names to what the native module takes.

Steering is a dict, every key optional: `weights` {term: number}, `locked` and `pinned` lists of bone names, `proportions` {bone name:
[least, largest]}, `apart` pairs of bone names whose parts should get in each other's way less, `pose` the embedding in which locked joints have their angles and pinned bones their places, unless the search starts from a
pose: then it is that one.
"""
from .options import UserError

USUAL_WEIGHTS = {"compact": 1.0, "skin": 1.0, "skeleton": 1e3, "protrude": 1e3, "morphology": 0.01, "unfold": 300.0}  # the native module's
KEYS = ("weights", "locked", "pinned", "proportions", "apart", "pose")


def native_arguments(steering, character, bodies, pose, bone_frames):
    """Keyword arguments for the native `embed` and `explore`.

    `character` has first_angle and hinges of each body; `bodies` says of each bone's name which body it belongs to: bones fixed to one
    another steer the body that they are; `pose` is an Embedding or None; `bone_frames(pose)` gives each body's frame. Raises UserError.
    """
    unknown = [key for key in steering if key not in KEYS]
    if unknown:
        raise UserError(f"steering knows {', '.join(KEYS)}, not {unknown[0]!r}")
    locked, pinned = ([_body(bodies, name) for name in steering.get(key) or ()] for key in ("locked", "pinned"))
    if pinned and pose is None:
        raise UserError("pinned bones need a folded pose that says where they are: find or pose one first")
    angles = []
    for body in dict.fromkeys(locked):
        first = character.first_angle[body]
        angles += [(k, pose.angles[k] if pose else 0.0) for k in range(first, first + len(character.hinges[body]))]
    frames = bone_frames(pose) if pinned else ()
    bounds = {_body(bodies, name): (float(least), float(largest)) for name, (least, largest) in (steering.get("proportions") or {}).items()}
    return {"weights": {term: float(weight) for term, weight in (steering.get("weights") or {}).items()}, "locked": angles,
            "pinned": [(body, list(frames[body])) for body in dict.fromkeys(pinned)],
            "proportion_of": [(body, *limits) for body, limits in bounds.items()]}


def pairs_apart(steering, bodies):
    """The bodies of the pairs that are to be kept apart. Raises UserError."""
    return [(_body(bodies, one), _body(bodies, other)) for one, other in steering.get("apart") or ()]


def _body(bodies, name):
    if name not in bodies:
        raise UserError(f"the character has no bone '{name}': list its bones again")
    return bodies[name]
