# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user can choose for a design: shared by the headless command and the panel."""
from dataclasses import asdict, dataclass
import math


class UserError(Exception):
    """The user's data or choice can't be used; the text is one line: what is wrong, and what to do."""


SYMMETRIES = ("auto", "on", "off")
STYLES = ("solid", "shell")
FITS = ("auto", "off")
TRANSFERS = ("auto", "cylinder", "exact")
LARGEST_AUTO_BONES = 25  # of CONTRACT.md: auto takes a character of over 25 bones down to 25 at most


@dataclass
class DesignOptions:
    resolution: int = 64        # voxels along the target's longest side
    seed: int = 0
    symmetry: str = "auto"      # one of SYMMETRIES
    simplify: str = "auto"      # auto, off, or the largest number of bones
    fit: str = "auto"           # auto: scale the character to suit the target; off: keep its size
    proportions: bool = True    # let the optimiser scale bones
    size_mm: float = 150.0      # printed length of the target's longest side
    clearance_mm: float = 0.3   # gap between neighbouring parts
    style: str = "solid"        # one of STYLES
    wall_mm: float = 1.2        # of shells
    transfer: str = "auto"      # one of TRANSFERS: how parts that share a joint make room for its turn
    hinges: bool = True         # a pin, a clevis and a tongue at joints of one axis, where there is room; else balls in sockets
    frames: int = 0             # length of the fold's action; 0: by the angles turned
    together: bool = True       # joints whose moves follow each other turn at the same time where that is proved to be safe
    loop: bool = False          # the action goes back from object mode to character mode, so that it repeats without a jump
    fold_seconds: float = 20.0  # for the search of the fold's order: how much is tried, and a limit on a machine too slow for that
    threads: int = 0            # 0: all cores; the design does not depend on it

    def validate(self):
        """Raises UserError, one line, at the first choice that can't be used."""
        _whole("resolution", self.resolution, 16, 512)
        _whole("seed", self.seed, 0, 2 ** 63 - 1)
        _one_of("symmetry", self.symmetry, SYMMETRIES)
        _one_of("fit", self.fit, FITS)
        _one_of("style", self.style, STYLES)
        _one_of("transfer", self.transfer, TRANSFERS)
        if not isinstance(self.proportions, bool):
            raise UserError(f"proportions is {self.proportions!r}: choose on or off")
        self.bone_limit()
        _number("size", self.size_mm, 1.0, 100000.0, " mm")
        _number("clearance", self.clearance_mm, 0.0, self.size_mm / 20, " mm (a twentieth of the size at most)")
        _number("wall", self.wall_mm, 0.1, self.size_mm / 4, " mm (a quarter of the size at most)")
        _whole("frames", self.frames, 0, 100000)
        if self.frames == 1:
            raise UserError("frames is 1: a fold needs at least 2 frames (0: chosen by the angles turned)")
        for name in ("hinges", "together", "loop"):
            if not isinstance(getattr(self, name), bool):
                raise UserError(f"{name} is {getattr(self, name)!r}: choose on or off")
        _number("fold_seconds", self.fold_seconds, 0.1, 3600.0, " s")
        _whole("threads", self.threads, 0, 1024)

    def bone_limit(self):
        """The largest number of bones that Simplify leaves; None when it is off."""
        if self.simplify == "off":
            return None
        if self.simplify == "auto":
            return LARGEST_AUTO_BONES
        try:
            limit = int(self.simplify)
        except (TypeError, ValueError):
            raise UserError(f"simplify is {self.simplify!r}: choose auto, off, or a number of bones") from None
        if limit < 2:
            raise UserError(f"simplify is {limit}: a character needs at least 2 bones")
        return limit

    def target_units(self, millimetres):
        """A printed length in target units: the longest side is `size_mm` in print and 0.5 in the target's frame."""
        return millimetres * LONGEST_SIDE / self.size_mm

    def millimetres(self, target_units):
        return target_units * self.size_mm / LONGEST_SIDE

    def as_dict(self):
        return asdict(self)


LONGEST_SIDE = 0.5  # of every target in the target's frame


def _whole(name, value, least, largest):
    if isinstance(value, bool) or not isinstance(value, int):
        raise UserError(f"{name} is {value!r}: choose a whole number")
    if not least <= value <= largest:
        raise UserError(f"{name} is {value}: choose a whole number from {least} to {largest}")


def _number(name, value, least, largest, unit):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UserError(f"{name} is {value!r}: choose a number")
    if not least <= value <= largest:
        raise UserError(f"{name} is {value:g}: choose a number from {least:g} to {largest:g}{unit}")


def _one_of(name, value, choices):
    if value not in choices:
        raise UserError(f"{name} is {value!r}: choose {', '.join(choices[:-1])} or {choices[-1]}")
