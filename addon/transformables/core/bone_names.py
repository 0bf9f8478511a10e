# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bone's name tells: its side, and how likely it is that a toy needs it."""
from __future__ import annotations

import re

# Weights are multiplied into the cost of losing a bone: below 1, it goes early.
_FACE = set("""face nose nostril lip lips mouth jaw chin ear ears brow eyebrow lid eyelid eye eyes pupil forehead temple
    cheek teeth tooth tongue beak skull whisker""".split())
_FINGERS = set("finger fingers thumb index middle ring pinky pinkie palm digit metacarpal carpal claw".split())
_HELPERS = set("""heel breast bust boob helper twist roll control controller ctrl ctl pole ik target tgt mch widget end nub tip
    jiggle corrective muscle prop weapon socket attach belly feather hair cloth skirt strap""".split())
_KEPT = set("""arm forearm upperarm lowerarm leg upleg thigh calf shin foot hand wing shoulder clavicle knee elbow paw
    upper lower fore head""".split())
_TRUNK = set("spine neck chest torso hips tail pelvis back waist abdomen".split())

HELPER_WEIGHT = 0.05
FACE_WEIGHT = 0.05
FINGER_WEIGHT = 0.1
TOE_WEIGHT = 0.25
KEPT_WEIGHT = 1.5

_SIDES = [("l", "r"), ("L", "R"), ("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")]


def words(name):
    """'mixamorig:LeftHandIndex1' -> ['mixamorig', 'left', 'hand', 'index']."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return [word.lower() for word in re.findall(r"[A-Za-z]+", spaced)]


def weight_of_name(name, leaf):
    """(weight of the bone, weight that its descendants are held down to); 1 where the name tells nothing."""
    found = set(words(name))
    sided = name_of_other_side(name) != name
    body = found & (_KEPT | _TRUNK)
    if found & _HELPERS or ("pelvis" in found and (sided or leaf)):
        return HELPER_WEIGHT, 1.0   # what hangs on a helper may be a limb
    if found & _FACE:
        return FACE_WEIGHT, FACE_WEIGHT
    # 'middle' and 'ring' are fingers only where no limb or trunk is named: 'spine_middle'. 'LeftHandMiddle1' is one.
    if found & _FINGERS and (not body or body == {"hand"} or body == {"foot"}):
        return FINGER_WEIGHT, FINGER_WEIGHT
    if found & {"toe", "toes"}:
        return TOE_WEIGHT, TOE_WEIGHT
    if found & _KEPT:
        return KEPT_WEIGHT, 1.0
    return 1.0, 1.0


def _other_word(word):
    for pair in _SIDES:
        for this, other in (pair, pair[::-1]):
            if word == this:
                return other
            if len(this) == 1:
                continue
            if word.startswith(this):
                return other + word[len(this):]
            if word.endswith(this):
                return word[:-len(this)] + other
    return word


def name_of_other_side(name):
    """The name with its side changed: `.L/.R`, `_l/_r`, `left/right`; the same name when it tells no side."""
    pieces = re.split(r"([._\- :])", name)
    for i, piece in enumerate(pieces):
        other = _other_word(piece)
        if other != piece:
            return "".join(pieces[:i] + [other] + pieces[i + 1:])
    return name
