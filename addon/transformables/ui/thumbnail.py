# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of a folded skeleton in the shadow of its target, drawn by ourselves: they need no GPU and no window."""

import base64
import zlib

import bpy.utils.previews
import numpy as np

SIDE = 64
SHADOW, BONE = 1, 128       # bone k is drawn as BONE + k % COLOURS
COLOURS = 8
SAMPLES = 60000             # points on the target's surface, so that its shadow has no holes
_icons = []                 # the one collection of previews, made when first needed


def draw(vertices, triangles, points):
    """The picture as text, to be kept in the .blend. vertices, points: world space, n x 3; points two a line."""
    vertices, points = np.asarray(vertices, float), np.asarray(points, float).reshape(-1, 2, 3)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    across, up = sorted(np.argsort(high - low)[1:])  # the two longer sides of the target
    scale = 0.9 * SIDE / max(high - low)
    middle = 0.5 * (low + high)[[across, up]]

    def pixels(p):
        return np.clip(np.round((p[..., [across, up]] - middle) * scale + SIDE / 2).astype(int), 0, SIDE - 1)

    picture = np.zeros((SIDE, SIDE), np.uint8)
    x, y = pixels(_on_surface(vertices, np.asarray(triangles))).T
    picture[y, x] = SHADOW
    for k, (a, b) in enumerate(points):
        steps = np.linspace(0, 1, 2 * SIDE)[:, None]
        x, y = pixels(a + steps * (b - a)).T
        for dx, dy in ((0, 0), (1, 0), (0, 1)):
            picture[np.minimum(y + dy, SIDE - 1), np.minimum(x + dx, SIDE - 1)] = BONE + k % COLOURS
    return base64.b64encode(zlib.compress(picture.tobytes(), 9)).decode()


def _on_surface(vertices, triangles):
    """Points spread evenly over the triangles' areas; the same for the same mesh."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    random = np.random.RandomState(0)
    of = np.searchsorted(np.cumsum(areas), random.rand(SAMPLES) * areas.sum()).clip(0, len(areas) - 1)
    u, v = random.rand(2, SAMPLES, 1)
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[of] + u * (b[of] - a[of]) + v * (c[of] - a[of])


def pixels_of(text):
    """SIDE x SIDE x 4 floats, from the lowest row up; transparent where nothing is."""
    picture = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(SIDE, SIDE)
    turn = 2 * np.pi * (np.arange(COLOURS) / COLOURS)[:, None] + np.array([0, 2.1, 4.2])
    colours = np.zeros((256, 4), np.float32)
    colours[SHADOW] = (0.5, 0.5, 0.5, 0.45)
    colours[BONE:BONE + COLOURS, :3] = 0.65 + 0.35 * np.cos(turn)
    colours[BONE:BONE + COLOURS, 3] = 1
    return colours[picture]


def icon(text):
    """The number of an icon that shows this picture."""
    if not _icons:
        _icons.append(bpy.utils.previews.new())
    if text not in _icons[0]:
        preview = _icons[0].new(text)
        for kind in ("icon", "image"):
            setattr(preview, f"{kind}_size", (SIDE, SIDE))
            getattr(preview, f"{kind}_pixels_float").foreach_set(pixels_of(text).ravel())
    return _icons[0][text].icon_id


def unregister():
    while _icons:
        bpy.utils.previews.remove(_icons.pop())
