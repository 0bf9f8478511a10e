# SPDX-License-Identifier: GPL-3.0-or-later
"""Which places of a surface change hands while a seam is dragged over it."""
import numpy as np
import pytest

from transformables.core import division


def tube(count=80, rows=81, radius=1.0, length=4.0):
    """Vertices, triangles of an open tube along Z, and each vertex' angle."""
    angle, z = (g.ravel() for g in np.meshgrid(2 * np.pi * np.arange(count) / count, np.linspace(-length / 2, length / 2, rows)))
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    at = lambda i, j: j * count + i % count  # noqa: E731
    triangles = [t for j in range(rows - 1) for i in range(count) for t in
                 ((at(i, j), at(i + 1, j), at(i, j + 1)), (at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))]
    return vertices, np.array(triangles), angle


def ring(height, count=100):
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle), np.broadcast_to(height(angle), count)], axis=1)


def bulge(angle, by):
    return by * np.maximum(0, np.cos(angle)) ** 2


def test_normals_of_a_tube_point_outward():
    vertices, triangles, _ = tube()
    normals = division.normals(vertices, triangles)
    assert np.allclose(normals[:, :2], vertices[:, :2], atol=0.05) and np.abs(normals[:, 2]).max() < 0.05


@pytest.mark.parametrize("by", (0.6, -0.6))
@pytest.mark.parametrize("backwards", (False, True))
def test_places_that_the_seam_passes_over_change_hands_and_no_others(by, backwards):
    vertices, triangles, angle = tube()
    parts = np.where(vertices[:, 2] < 0.01, 3, 5).astype(np.int32)
    turn = slice(None, None, -1 if backwards else 1)
    dragged = division.Dragged(vertices, division.normals(vertices, triangles), parts, (3, 5), ring(lambda a: 0.01 + 0 * a)[turn], True, 0.07)
    moved = dragged.moved(ring(lambda a: 0.01 + bulge(a, by))[turn])
    expected = np.where(vertices[:, 2] < 0.01 + bulge(angle, by), 3, 5)
    clear = np.abs(vertices[:, 2] - 0.01 - bulge(angle, by)) > 0.02
    assert (moved != parts).sum() > 200
    assert (moved == expected)[clear].all()


def test_a_third_part_and_the_two_parts_other_seams_are_left_alone():
    vertices, triangles, angle = tube()
    z = vertices[:, 2]
    parts = np.where(z < 0.01, 0, np.where(z < 0.31, 1, 0)).astype(np.int32)  # a band between two seams of the same two
    parts[np.abs(angle - np.pi) < 0.5] = 2
    dragged = division.Dragged(vertices, division.normals(vertices, triangles), parts, (0, 1), ring(lambda a: 0.01 + 0 * a), True, 0.07)
    moved = dragged.moved(ring(lambda a: 0.01 + 0.2))
    changed = moved != parts
    assert (moved[parts == 2] == 2).all() and (z[changed] < 0.25).all() and (parts[changed] == 1).all()
    assert changed[(parts == 1) & (z < 0.2)].all()


def test_the_other_face_of_a_thin_sheet_is_left_alone():
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41)), axis=-1).reshape(-1, 2)
    squares = [41 * j + i for j in range(40) for i in range(40)]
    up = np.array([t for s in squares for t in ((s, s + 1, s + 41), (s + 1, s + 42, s + 41))])
    vertices = np.concatenate([np.c_[grid, np.full(len(grid), z)] for z in (0.01, -0.01)])
    normals = division.normals(vertices, np.concatenate([up, up[:, ::-1] + len(grid)]))
    parts = (vertices[:, 0] > 0.01).astype(np.int32)
    y = np.linspace(-1, 1, 50)
    curve = np.stack([np.full(50, 0.01), y, np.full(50, 0.01)], axis=1)
    moved = division.Dragged(vertices, normals, parts, (0, 1), curve, False, 0.05).moved(curve + np.stack([0.3 * np.exp(-(4 * y) ** 2), 0 * y, 0 * y], axis=1))
    changed = moved != parts
    assert changed.sum() > 20 and (vertices[changed, 2] > 0).all()


def test_a_seam_that_stays_changes_nothing():
    vertices, triangles, _ = tube(count=20, rows=21)
    parts = (vertices[:, 2] > 0).astype(np.int32)
    curve = ring(lambda a: 0.1 + 0 * a)
    dragged = division.Dragged(vertices, division.normals(vertices, triangles), parts, (0, 1), curve, True, 0.3)
    assert (dragged.moved(curve) == parts).all()
