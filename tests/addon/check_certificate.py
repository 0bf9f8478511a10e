# SPDX-License-Identifier: GPL-3.0-or-later
"""Replays a certificate (`--certificate FILE` of the headless command) without any of the program's code.

    python3 check_certificate.py CERTIFICATE.json [ROWS]

What is checked for all intervals: every pair of parts is there in the first move, those that move against each other in later ones; the
intervals follow each other from 0 to 1; no bound is under the stated gap. Intervals of parts so far apart that their bounding balls
and our own bound of their speed prove the interval are done. Of the others ROWS (default 40; the tightest, and some by lot) are
measured: the triangles themselves, at the beginning, the middle and the end.
"""
import base64
import json
import math
import random
import sys

import numpy as np

AT_ONCE = 20_000  # pairs of triangles
ROUNDING = 1e-6   # what parts' places may differ by: single precision at lengths of 0.5


class Refused(Exception):
    """The certificate does not say what it should, or says what is not so."""


def check(document, rows=40, seed=0):
    """Raises Refused; gives {intervals, proved, measured}. `rows` None: measure all that are not proved."""
    design = _Design(document)
    if not document["holds"] or document["open"]:
        raise Refused(f"it does not hold: {len(document['open'])} places are open")
    if not document["gap"] > 0:
        raise Refused("its gap is not positive")
    _check_cover(design, document)
    left = [row for row in document["intervals"] if not design.proves(row)]
    chosen = left if rows is None else _chosen(left, rows, seed)
    for row in chosen:
        design.measure(row)
    return {"intervals": len(document["intervals"]), "proved": len(document["intervals"]) - len(left), "measured": len(chosen)}


def _chosen(rows, count, seed):
    tightest = sorted(rows, key=lambda row: row[5])[:count // 2]
    others = [row for row in rows if row not in tightest]
    return tightest + random.Random(seed).sample(others, min(count - len(tightest), len(others)))


def _check_cover(design, document):
    found = {}
    for row in document["intervals"]:
        move, a, b, t0, t1, bound = row
        if not bound >= document["gap"]:
            raise Refused(f"{_name(row)}: its bound {bound} is under the gap {document['gap']}")
        found.setdefault((move, a, b), []).append((t0, t1))
    bones = sorted(design.meshes)
    for move in range(max(1, len(design.moves))):
        for i, a in enumerate(bones):
            for b in bones[i + 1:]:
                if move > 0 and not design.rates_between(move, a, b):
                    continue
                reached = 0.0
                for t0, t1 in sorted(found.get((move, a, b), [])):
                    if t0 > reached or t1 <= t0:
                        break
                    reached = max(reached, t1)
                if reached < 1.0:
                    raise Refused(f"bones {a} and {b} in move {move}: nothing is said from {reached} on")


class _Design:
    def __init__(self, document):
        self.bodies, self.moves = document["bodies"], document["moves"]
        self.meshes = {}
        for part in document["parts"]:
            vertices = np.frombuffer(base64.b64decode(part["vertices"]), dtype="<f4").reshape(-1, 3).astype(float)
            triangles = np.frombuffer(base64.b64decode(part["triangles"]), dtype="<i4").reshape(-1, 3)
            self.meshes[part["bone"]] = vertices[triangles]
        self.starts = [list(document["angles"])]
        for turns in self.moves:
            now = list(self.starts[-1])
            for angle, start, end in turns:
                if abs(now[angle] - start) > 1e-5:
                    raise Refused(f"a move starts angle {angle} at {start}, where it is at {now[angle]}")
                now[angle] = end
            self.starts.append(now)

    def line(self, bone):
        bones = []
        while bone >= 0:
            bones.append(bone)
            bone = self.bodies[bone]["parent"]
        return bones

    def between(self, a, b):
        """The bones whose joints lie between two."""
        up, down = self.line(a), self.line(b)
        return [x for x in up if x not in down] + [x for x in down if x not in up]

    def rates_between(self, move, a, b):
        if move >= len(self.moves):
            return []
        own = {self.bodies[x]["first_angle"] + k for x in self.between(a, b) for k in range(len(self.bodies[x]["hinges"]))}
        return [abs(end - start) for angle, start, end in self.moves[move] if angle in own and start != end]

    def frames(self, move, t):
        angles = list(self.starts[move])
        for angle, start, end in self.moves[move] if move < len(self.moves) else []:
            angles[angle] = start + t * (end - start)
        frames = []
        for body in self.bodies:
            turn = np.eye(3)
            for k, axis in enumerate(body["hinges"]):
                turn = _rotation(axis, angles[body["first_angle"] + k]) @ turn
            if body["parent"] < 0:
                frames.append((np.eye(3), np.zeros(3)))
                continue
            rotation, place = frames[body["parent"]]
            frames.append((rotation @ np.array(body["rest"]).reshape(3, 3) @ turn, place + rotation @ np.array(body["head"])))
        return frames

    def pair(self, move, t, a, b):
        """Triangles of a, in b's frame, and those of b."""
        frames = self.frames(move, t)
        (ra, pa), (rb, pb) = frames[a], frames[b]
        return ((self.meshes[a] @ ra.T + pa) - pb) @ rb, self.meshes[b]

    def proves(self, row):
        """Whether balls around the parts and a bound of their speed alone show the interval."""
        move, a, b, t0, t1, bound = row
        p, q = self.pair(move, 0.5 * (t0 + t1), a, b)
        (cp, rp), (cq, rq) = _ball(p), _ball(q)
        # No joint between the two is further from a point of A than the way to it along the bones.
        way = np.linalg.norm(self.meshes[a].reshape(-1, 3), axis=1).max()
        way += sum(np.linalg.norm(self.bodies[x]["head"]) for x in self.line(a)[:-1] + self.line(b)[:-1])
        travel = sum(self.rates_between(move, a, b)) * way * 0.5 * (t1 - t0)
        return np.linalg.norm(cp - cq) - rp - rq - travel - ROUNDING >= bound

    def measure(self, row):
        move, a, b, t0, t1, bound = row
        for t in (t0, 0.5 * (t0 + t1), t1):
            distance = mesh_distance(*self.pair(move, t, a, b), bound)
            if distance < bound - ROUNDING:
                raise Refused(f"{_name(row)}: the parts are {distance:.3g} apart at {t:.6f}, not {bound:.3g}")


def mesh_distance(p, q, reach):
    """The least distance of two lists of triangles where it is under `reach`; infinity where it is not."""
    p, q = _near(p, q, reach), _near(q, p, reach)
    best = math.inf
    if not len(p) or not len(q):
        return best
    cp, cq = p.mean(axis=1), q.mean(axis=1)
    rp = np.linalg.norm(p - cp[:, None], axis=2).max(axis=1)
    rq = np.linalg.norm(q - cq[:, None], axis=2).max(axis=1)
    order = np.argsort(cq[:, 0])
    q, cq, rq = q[order], cq[order], rq[order]
    widest = rq.max()
    pairs, waiting = [], 0
    for n in range(len(p)):
        radius = reach + rp[n] + widest
        first, last = np.searchsorted(cq[:, 0], (cp[n, 0] - radius, cp[n, 0] + radius))
        near = first + np.flatnonzero(np.linalg.norm(cq[first:last] - cp[n], axis=1) < reach + rp[n] + rq[first:last])
        pairs.append((n, near))
        waiting += len(near)
        if waiting and (waiting > AT_ONCE or n + 1 == len(p)):
            mine = np.repeat([m for m, _ in pairs], [len(others) for _, others in pairs])
            best = min(best, triangle_distances(p[mine], q[np.concatenate([others for _, others in pairs])]).min())
            pairs, waiting = [], 0
    return best


def triangle_distances(a, b):
    """Distances of triangles pair by pair; 0 where they cross."""
    best = np.full(len(a), math.inf)
    for i in range(3):
        for j in range(3):
            best = np.minimum(best, _edge_distances(a[:, i], a[:, (i + 1) % 3], b[:, j], b[:, (j + 1) % 3]))
    for s, t in ((a, b), (b, a)):
        normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
        normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        heights = [_dot(normal, s[:, k] - t[:, 0]) for k in range(3)]
        for k in range(3):
            m = (k + 1) % 3
            best = np.where(_over(t, normal, s[:, k]), np.minimum(best, abs(heights[k])), best)
            share = heights[k] / np.where(heights[k] == heights[m], 1.0, heights[k] - heights[m])
            crossing = (heights[k] * heights[m] <= 0) & _over(t, normal, s[:, k] + share[:, None] * (s[:, m] - s[:, k]))
            best = np.where(crossing & (heights[k] != heights[m]), 0.0, best)
    return best


def _over(t, normal, p):
    inside = np.linalg.norm(normal, axis=1) > 0.5
    for k in range(3):
        inside &= _dot(normal, np.cross(t[:, (k + 1) % 3] - t[:, k], p - t[:, k])) >= 0
    return inside


def _edge_distances(p0, p1, q0, q1):
    """Segments: the best of the lines' nearest points, where both fall inside, and of each end against the other segment."""
    u, v, w = p1 - p0, q1 - q0, p0 - q0
    a, b, c, d, e = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    det = a * c - b * b
    safe = np.where(det > 1e-14 * a * c, det, 1.0)
    s, t = (b * e - c * d) / safe, (a * e - b * d) / safe
    inside = (det > 1e-14 * a * c) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    best = np.where(inside, np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1), math.inf)
    for point, start, along in ((p0, q0, v), (p1, q0, v), (q0, p0, u), (q1, p0, u)):
        share = np.clip(_dot(point - start, along) / np.maximum(_dot(along, along), 1e-300), 0, 1)
        best = np.minimum(best, np.linalg.norm(point - start - share[:, None] * along, axis=1))
    return best


def _near(p, q, reach):
    """Triangles of p whose box comes within reach of q's."""
    low, high = q.min(axis=(0, 1)) - reach, q.max(axis=(0, 1)) + reach
    return p[((p.max(axis=1) >= low) & (p.min(axis=1) <= high)).all(axis=1)]


def _ball(triangles):
    points = triangles.reshape(-1, 3)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return centre, np.linalg.norm(points - centre, axis=1).max()


def _rotation(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    m = np.eye(3)
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def _dot(a, b):
    return np.einsum("ij,ij->i", a, b)


def _name(row):
    return f"bones {row[1]} and {row[2]} in move {row[0]} from {row[3]} to {row[4]}"


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        certificate = json.load(file)
    try:
        done = check(certificate, int(sys.argv[2]) if len(sys.argv) > 2 else 40)
    except Refused as refused:
        sys.exit(f"refused: {refused}")
    print(f"holds: {done['intervals']} intervals, {done['proved']} proved again, {done['measured']} measured")
