# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams as curves, and how a pull at one point moves its neighbours. Plain lists of (x, y, z); no bpy."""
import math


def along(points, closed, index):
    """Distance of every point from point `index` along the curve, the shorter way round when it is closed."""
    steps = [math.dist(a, b) for a, b in zip(points, points[1:])]
    total = [0.0]
    for step in steps:
        total.append(total[-1] + step)
    ways = [abs(t - total[index]) for t in total]
    if closed:
        length = total[-1] + math.dist(points[-1], points[0])
        ways = [min(way, length - way) for way in ways]
    return ways


def weights(points, closed, index, size):
    """How much of a pull at point `index` each point follows: 1 there, 0 from `size` along the curve on, smooth between."""
    fall = [max(0.0, 1.0 - way / size) if size > 0 else float(way == 0) for way in along(points, closed, index)]
    return [t * t * (3 - 2 * t) for t in fall]


def pulled(points, closed, index, displacement, size, snap):
    """The curve after a pull; `snap(point)` puts a point back on the surface. Points that do not move are left as they are."""
    return [snap(tuple(p + w * d for p, d in zip(point, displacement))) if w > 0 else tuple(point)
            for point, w in zip(points, weights(points, closed, index, size))]


def worth_sending(points, moved, margin):
    """Indices of the points that move, and of those within `margin` points of one: they hold the rest of the seam in its place."""
    moving = [i for i, (a, b) in enumerate(zip(points, moved)) if math.dist(a, b) > 0]
    near = {(i + k) % len(points) for i in moving for k in range(-margin, margin + 1)}
    return sorted(near)
