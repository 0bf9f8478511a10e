# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for the native module where only the plumbing is tested: processes, frames, the order of rooms.

It designs nothing: every bone gets the same small box. The seed chooses how it behaves.
"""
import os
import signal
import struct
import sys
import time
from types import SimpleNamespace

version = "stand-in"
CALM, ANSWERS_SLOWLY, DEAF, KILLED, HUNGRY, BAD_INPUT, FAULT, NOISY, ABORTS, INFEASIBLE = range(10)
LONG = 30.0
TETRAHEDRON = ((0, 0, 0), (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
calls = []
searches = []  # what each search was told
transfers = []  # what each transfer was told
budgets = []   # expansions and seconds of each search for an order


class InvalidInput(ValueError):
    pass


class Infeasible(RuntimeError):
    pass


class Cancelled(RuntimeError):
    pass


def _told(progress, fraction, note=""):
    if progress and not progress(fraction, note):
        raise Cancelled("cancelled")


def make_character(*, names, parents, heads, tails, axes, hinges):
    calls.append("make_character")
    first, count = [], 0
    for row in hinges:
        first.append(count)
        count += len(row)
    return SimpleNamespace(names=list(names), members=[[i] for i in range(len(names))], parents=list(parents),
                           hinges=[list(h) for h in hinges], angle_count=count, first_angle=first, mirrored=False, scale=1.0)


def make_target(*, vertices, triangles, resolution=64, progress=None):
    calls.append("make_target")
    _told(progress, 0.5)
    return SimpleNamespace(scale=0.25, centre=[1.0, 2.0, 3.0], volume=0.06, grid=[resolution] * 3,
                           warnings=["2 vertices were welded"], mirror_axis=None, resolution=resolution)


def fitted(character, target, *, least_radius, scale=0.0):
    calls.append("fitted")
    assert least_radius > 0
    character.scale = scale or 0.5
    return character


class Embedding:
    def __init__(self, *, root, angles, morphology, symmetric=False):
        self.root, self.angles, self.morphology, self.symmetric = root, angles, morphology, symmetric
        self.terms, self.deepest_protrusion, self.deepest_collision = {"compact": 0.1, "total": 0.25}, 0.0, 0.0
        self.value, self.missed = 0.25, 0.0


def embed(character, target, *, seed=0, symmetry="auto", proportions=True, threads=0, weights=None, locked=(), pinned=(), proportion_of=(),
          edits=(), start=None, progress=None, best=None, trying=None):
    calls.append("embed")
    searches.append({"weights": weights, "locked": locked, "pinned": pinned, "proportion_of": proportion_of, "start": start, "edits": edits})
    _behave(seed, progress)
    embedding = Embedding(root=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.1, 0, 0, 1], angles=[0.5] * character.angle_count,
                          morphology=[1.0] * len(character.names))
    if best:
        best(embedding)
    _told(progress, 1.0)
    return embedding


def explore(character, target, *, count=5, least_difference=0.15, evaluations=12000, found=None, **search):
    best = embed(character, target, **search)
    calls[-1] = "explore"
    others = [Embedding(root=best.root, angles=[0.1 * k] * character.angle_count, morphology=best.morphology) for k in range(1, count)]
    return [best, *others]


def skeleton_fit(character, target, embedding):
    return {"protrusion": [0.0] * (len(character.names) - 1) + [0.1], "collisions": [(0, 1, 0.01)] if len(character.names) > 1 else []}


def bone_frames(character, embedding):
    return [[1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, float(i), 0, 0, 1] for i in range(len(character.names))]


def _behave(seed, progress):
    began = time.monotonic()
    while seed == ANSWERS_SLOWLY and time.monotonic() - began < LONG:
        _told(progress, 0.1, "slowly")
        time.sleep(0.01)
    if seed == DEAF:
        _told(progress, 0.1, "deaf")
        time.sleep(LONG)
    if seed == KILLED:
        os.kill(os.getpid(), signal.SIGKILL)
    if seed == HUNGRY:
        return bytearray(8 << 30)
    if seed == BAD_INPUT:
        raise InvalidInput("bone 'arm': its range is empty:\n  give it one")
    if seed == INFEASIBLE:
        raise Infeasible("the character does not fit: allow more voxels")
    if seed == FAULT:
        raise KeyError("unforeseen")
    if seed == NOISY:
        for _ in range(2000):
            print("a library talks to standard output, at length " * 4)
            os.write(1, b"TFM1 and so does its C code\n")
        sys.stdout.flush()
    if seed == ABORTS:
        sys.stderr.write("terminate called after throwing an instance of 'std::bad_alloc'\n")
        sys.stderr.flush()
        os.abort()


def grow(character, target, embedding, *, threads=0, progress=None):
    calls.append("grow")
    return SimpleNamespace(volumes=[0.01] * len(character.names))


def transfer(segmentation, character, target, embedding, *, ranges="straight", method="auto", direction_of=None, round_off=True, threads=0, progress=None):
    calls.append("transfer")
    transfers.append((method, direction_of))
    return segmentation


def make_edit(target, *, kind, bone="", other="", name="", reach=0.0, painted=b"", from_points=b"", to_points=b""):
    return SimpleNamespace(kind=kind, bone=bone, other=other, name=name, reach=reach, painted=painted, from_points=from_points, to_points=to_points)


def seams(segmentation, target):
    """One, around the middle of the box that tests use."""
    corners = ((-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1))
    points = [tuple(a + (b - a) * k / 10 for a, b in zip(p, q)) for p, q in zip(corners, corners[1:] + corners[:1]) for k in range(10)]
    return [{"bone_a": 0, "bone_b": 1, "closed": True, "points": struct.pack("<120d", *(x for p in points for x in p))}]


def division(segmentation, target, *, spacing=1.0):
    """A strip of squares across the seam."""
    assert spacing >= 1
    places = [(-1 + 0.1 * i, y, -1) for i in range(21) for y in (-0.3, -0.1, 0.1, 0.3)]
    squares = [4 * i + j for i in range(20) for j in range(3)]
    corners = [k for s in squares for k in (s, s + 4, s + 1, s + 1, s + 4, s + 5)]
    return {"vertices": struct.pack(f"<{3 * len(places)}d", *(x for p in places for x in p)), "triangles": struct.pack(f"<{len(corners)}i", *corners),
            "bones": struct.pack(f"<{len(places)}i", *(int(p[1] > 0) for p in places))}


def edited(segmentation, character, target, embedding, edits, *, threads=0):
    calls.append(("edited", edits))
    return segmentation, [f"edit {edit.kind} was told of" for edit in edits if edit.bone == "nobody"]


class FoldPath:
    def __init__(self, *, moves):
        self.moves, self.overlap_volume, self.collisions, self.cut_short = moves, 0.0, [], False


def fold(segmentation, character, target, embedding, *, rounds=5, expansions=3000, seconds=0.0, round_off=True, threads=0, progress=None):
    calls.append("fold")
    budgets.append((expansions, seconds))
    path = FoldPath(moves=[[(i, angle, 0.0)] for i, angle in enumerate(embedding.angles)])
    if len(character.names) > 1 and path.moves:  # the further it is folded, the more is in the way
        swept = 4e-4 * abs(embedding.angles[-1])
        path.collisions.append({"bone_a": 0, "bone_b": 1, "move": 0, "fraction": 0.5, "volume": 1e-4, "swept": swept, "place": [0.0, 0.01, 0.0]})
    return SimpleNamespace(path=path, segmentation=segmentation, carving_before=0.0, carving_after=0.0)


def transfer_along(segmentation, character, target, embedding, path, *, threads=0, progress=None):
    calls.append("transfer_along")
    return segmentation


def certify(parts, character, embedding, path, *, enough, least, tolerance, steps, pairs=(), to_the_end=True, threads=0, progress=None):
    """Nothing ever touches, but for joints that turn by more than a radian at the same time."""
    calls.append("certify")
    _told(progress, 0.5)
    turned = sum(abs(end - start) for turns in path.moves for _, start, end in turns)
    rows = [(m, b, a, 0.0, 1.0, 0.001) for m in range(len(path.moves)) for a in range(len(character.names)) for b in range(a) if not pairs or (b, a) in pairs]
    return SimpleNamespace(holds=turned <= 1.0, gap=0.001 if turned <= 1.0 else 0.0, open=[], intervals=rows)


def finish(segmentation, character, target, embedding, path, *, clearance, style="solid", wall=0.004, hinges=True, threads=0, progress=None):
    calls.append("finish")
    vertices = struct.pack("<12d", *(x for v in TETRAHEDRON for x in v))
    triangles = struct.pack("<12i", *(i for f in FACES for i in f))
    parts = [{"bone": i, "vertices": vertices, "triangles": triangles, "volume": 2e-5} for i in range(len(character.names))]
    _told(progress, 1.0)
    pairs = [(a, b) for a in range(len(character.names)) for b in range(a)]
    certificate = SimpleNamespace(holds=True, gap=0.001, open=[], intervals=[(m, b, a, 0.0, 1.0, 0.001) for m in range(len(path.moves)) for a, b in pairs])
    return SimpleNamespace(parts=parts, certificate=certificate, collisions=[], minimum_clearance=0.001, carved_volume_pct=1.0,
                           filled_volume_pct=98.0, pinned=[1] if hinges and path.moves else [], warnings=[])
