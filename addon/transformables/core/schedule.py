# SPDX-License-Identifier: GPL-3.0-or-later
"""When each joint turns: from a path of moves (unfolding order) to frames of the fold (folding order).

Frame 1 is character mode, the last one object mode. Moves follow each other; between a move's first and last frame
its angles go by `eased`, all at the same rate, so that what was planned for the move holds at every instant.
"""
from dataclasses import dataclass
import math

FIRST_FRAME = 1
DEGREES_A_FRAME = 2.0
SHORTEST, LONGEST = 120, 250  # frames of an automatic fold: 5 to 10 seconds at 24 a second
LEAST_A_MOVE = 3
REST_TOLERANCE = 1e-6


@dataclass
class Step:
    """A move as it is shown: turns are (angle index, from, to) in folding direction."""

    move: int          # index into the path's moves (unfolding order)
    start: int         # frames
    end: int
    turns: list


@dataclass
class Schedule:
    steps: list
    last_frame: int

    def waypoints(self):
        """The frames at which something starts or ends, in order."""
        return sorted({FIRST_FRAME, self.last_frame, *(step.start for step in self.steps), *(step.end for step in self.steps)})

    def scene_end(self, loop):
        """The last frame to play: of a loop, the one before it would be in character mode again."""
        return 2 * self.last_frame - FIRST_FRAME - 1 if loop else self.last_frame

    def keys(self, angle_count):
        """For each angle its keyframes: [(frame, value, moves_on)]; moves_on: the curve eases to the next key."""
        keys = [[(FIRST_FRAME, 0.0, False)] for _ in range(angle_count)]
        for step in self.steps:
            for angle, start_value, end_value in step.turns:
                curve = keys[angle]
                if curve[-1][0] == step.start:
                    curve.pop()
                curve.append((step.start, start_value, True))
                curve.append((step.end, end_value, False))
        for curve in keys:
            if curve[-1][0] < self.last_frame:
                curve.append((self.last_frame, curve[-1][1], False))
        return keys

    def frame_of(self, move, fraction):
        """The frame at which a move (unfolding order) is at `fraction` of its way."""
        step = next(step for step in self.steps if step.move == move)
        return step.start + uneased(1.0 - fraction) * (step.end - step.start)

    def angles_at(self, frame, angle_count):
        """All angles at a frame, radians."""
        angles = [0.0] * angle_count
        for step in self.steps:
            t = min(1.0, max(0.0, (frame - step.start) / (step.end - step.start)))
            if t > 0:
                for angle, start_value, end_value in step.turns:
                    angles[angle] = start_value + (end_value - start_value) * eased(t)
        return angles


def eased(t):
    """Blender's SINE interpolation, easing in and out: no overshoot."""
    return 0.5 - 0.5 * math.cos(math.pi * t)


def uneased(value):
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * value))) / math.pi


def together(angles):
    """A path of one move that opens everything at once: what is shown before a path is planned."""
    turns = [[i, value, 0.0] for i, value in enumerate(angles) if abs(value) > REST_TOLERANCE]
    return [turns] if turns else []


def check_path(moves, folded_angles):
    """Raises ValueError unless the moves lead from the folded angles, without a jump, to rest."""
    now = list(folded_angles)
    for number, turns in enumerate(moves):
        for angle, start_value, end_value in turns:
            if not 0 <= angle < len(now):
                raise ValueError(f"move {number} turns angle {angle}, but there are {len(now)}")
            if abs(now[angle] - start_value) > 1e-5:
                raise ValueError(f"move {number} starts angle {angle} at {start_value:.6f}, where it is at {now[angle]:.6f}")
            now[angle] = end_value
    left = [i for i, value in enumerate(now) if abs(value) > 1e-5]
    if left:
        raise ValueError(f"the path leaves angles {left} away from rest")


def scheduled(moves, frames=0):
    """Lays moves (unfolding order: lists of (angle, from, to)) out over frames; `frames` 0: by the angles turned."""
    sizes = [math.degrees(max((abs(end - start) for _, start, end in turns), default=0.0)) for turns in moves]
    order = [m for m in reversed(range(len(moves))) if sizes[m] > 0]
    wanted = frames or min(LONGEST, max(SHORTEST, round(sum(sizes) / DEGREES_A_FRAME)))
    span = max(wanted - FIRST_FRAME, len(order) if frames else LEAST_A_MOVE * len(order), 1)
    steps, start = [], FIRST_FRAME
    for position, move in enumerate(order):
        rest = order[position:]
        share = (FIRST_FRAME + span - start) * sizes[move] / sum(sizes[m] for m in rest)
        least = 1 if frames else LEAST_A_MOVE
        largest = FIRST_FRAME + span - start - least * (len(rest) - 1)
        end = start + min(largest, max(least, round(share)))
        steps.append(Step(move, start, end, [(a, to, back) for a, back, to in moves[move]]))
        start = end
    return Schedule(steps, FIRST_FRAME + span)
