# SPDX-License-Identifier: GPL-3.0-or-later
"""The division of the target's surface while a seam is dragged: which of its places change hands. NumPy, no bpy."""
import numpy as np

MARGIN = 2  # edges of the surface's mesh: as far about the dragged curve places are looked at


class Dragged:
    """One seam of two parts, and the places (vertices of a fine mesh of the surface) that may go from one part to the other with it.

    `vertices` n x 3 and their `normals`, `parts` n (whose each is), `pair` the two parts, `curve` m x 3 where the seam runs now; `spacing`: the mesh's
    edges are about as long.
    """

    def __init__(self, vertices, normals, parts, pair, curve, closed, spacing):
        self._parts, self._pair, self._closed, self._reach = parts, pair, closed, MARGIN * spacing
        self._own = np.flatnonzero((parts == pair[0]) | (parts == pair[1]))  # of these two only: a third part keeps what it has
        self._places, self._normals = vertices[self._own].astype(np.float32), normals[self._own].astype(np.float32)
        self._second = parts[self._own] == pair[1]
        self._curve = np.asarray(curve, np.float32)
        self._sign = 1.0
        side, off, _ = self._sides(self._curve, np.arange(len(self._own)))
        near = off < 2 * self._reach
        if ((side > 0) != self._second)[near].mean() > 0.5:  # the curve runs the other way round
            self._sign = -1.0
        self._side = self._sign * side > 0

    def moved(self, curve):
        """Whose each place is, once the seam runs along `curve` (point by point where `self` was told it runs)."""
        curve = np.asarray(curve, np.float32)
        moving = np.abs(curve - self._curve).max(axis=1) > 0
        parts = self._parts.copy()
        if not moving.any():
            return parts
        farthest = np.linalg.norm(curve - self._curve, axis=1).max()
        corners = np.concatenate([curve[moving], self._curve[moving]])
        low, high = corners.min(axis=0) - self._reach, corners.max(axis=0) + self._reach
        band = np.flatnonzero(((self._places > low) & (self._places < high)).all(axis=1))
        side, off, same_sheet = self._sides(curve, band)
        side = self._sign * side > 0
        # A place changes hands when the curve passes over it. What was on its wrong side before lies at another seam of the two.
        passed = (side != self._side[band]) & (self._side[band] == self._second[band]) & (off < farthest + self._reach) & same_sheet
        parts[self._own[band[passed]]] = np.where(side[passed], self._pair[1], self._pair[0])
        return parts

    def _sides(self, curve, band):
        """On which side of a curve places lie, how far off, and whether on the same sheet of the surface."""
        if not len(band):
            return np.empty(0), np.empty(0), np.empty(0, bool)
        places, normals = self._places[band], self._normals[band]
        middle = curve.mean(axis=0)  # small numbers: distances of places come out of a difference
        a, b = places - middle, curve - middle
        squares = (a * a).sum(axis=1)[:, None] - 2 * (a @ b.T) + (b * b).sum(axis=1)
        nearest = squares.argmin(axis=1)
        upright = normals[squares.argmin(axis=0)]  # of the surface at each point of the curve
        across = np.cross(_tangents(curve, self._closed), upright)
        off = np.sqrt(np.maximum(squares[np.arange(len(band)), nearest], 0))
        return ((places - curve[nearest]) * across[nearest]).sum(axis=1), off, (normals * upright[nearest]).sum(axis=1) > 0


def _tangents(curve, closed):
    """Along a curve at each of its points; of any length."""
    if closed:
        return np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    return np.gradient(curve, axis=0)


def normals(vertices, triangles):
    """Outward unit normals of a mesh (n x 3, m x 3) at its vertices, by the area of the faces around each."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    sums = np.stack([np.bincount(triangles.ravel(), np.repeat(faces[:, k], 3), len(vertices)) for k in range(3)], axis=1)
    return sums / np.maximum(np.linalg.norm(sums, axis=1), 1e-30)[:, None]
