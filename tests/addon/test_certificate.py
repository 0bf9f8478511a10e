# SPDX-License-Identifier: GPL-3.0-or-later
"""The certificate's file and its independent checker, on a made-up arm whose distances are known."""
import copy
import os
import struct
import sys

import pytest

np = pytest.importorskip("numpy")
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import check_certificate as checker
from jobs import job_of, played, two_bones
from transformables.core import certificate

CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
REACH, WALL = 0.2, 0.23


def box(low, high):
    return {"vertices": certificate._encoded("f", [(low, high)[c[k]][k] for c in CORNERS for k in range(3)]),
            "triangles": certificate._encoded("i", [i for f in FACES for i in f])}


def honest(parts=32):
    """An arm about Z with a fin as long as REACH sweeps past the root's wall at WALL; nothing else moves."""
    bound = 0.9 * (WALL - REACH)
    return {"format": certificate.FORMAT, "holds": True, "gap": bound, "open": [], "angles": [-1.0], "moves": [[[0, -1.0, 1.0]]],
            "bodies": [{"name": "root", "parent": -1, "hinges": [], "first_angle": 0},
                       {"name": "arm", "parent": 0, "hinges": [2], "first_angle": 0, "head": [0, 0, 0], "rest": [1, 0, 0, 0, 1, 0, 0, 0, 1]}],
            "parts": [{"bone": 0, **box((WALL, -0.001, -0.05), (WALL + 0.01, 0.001, 0.05))},
                      {"bone": 1, **box((0.1, -0.0005, -0.05), (REACH, 0.0005, 0.05))}],
            "intervals": [[0, 0, 1, n / parts, (n + 1) / parts, bound] for n in range(parts)]}


def refused(spoil, match):
    document = copy.deepcopy(honest())
    spoil(document)
    with pytest.raises(checker.Refused, match=match):
        checker.check(document, rows=None)


def test_a_true_certificate_is_accepted_and_all_of_it_is_looked_at():
    done = checker.check(honest(), rows=None)
    assert done["intervals"] == 32 and done["proved"] + done["measured"] == 32 and done["measured"] > 0


def test_a_missing_interval_is_refused():
    for index in (0, 13, 31):
        refused(lambda d: d["intervals"].pop(index), "nothing is said from")


def test_a_missing_pair_or_move_is_refused():
    refused(lambda d: d["intervals"].clear(), "nothing is said")
    refused(lambda d: d["moves"].append([[0, 1.0, 0.5]]), "in move 1: nothing is said")


def test_a_raised_bound_is_refused():
    def raise_middle(document):
        document["intervals"][15][5] = 1.1 * (WALL - REACH)
    refused(raise_middle, "apart at")


def test_a_gap_above_a_bound_is_refused():
    refused(lambda d: d.update(gap=0.1), "under the gap")
    refused(lambda d: d.update(gap=0.0), "not positive")


def test_a_certificate_with_open_places_is_refused():
    refused(lambda d: d.update(holds=False), "does not hold")


def test_a_wall_moved_into_the_fins_way_is_refused():
    refused(lambda d: d["parts"][0].update(box((REACH - 0.01, -0.001, -0.05), (0.25, 0.001, 0.05))), "apart at")


def test_distances_of_triangles_agree_with_dense_points():
    random = np.random.default_rng(1)
    a, b = random.normal(size=(40, 3, 3)), random.normal(size=(40, 3, 3)) + [1.5, 0, 0]
    shares = np.array([(i, j, 30 - i - j) for i in range(31) for j in range(31 - i)]) / 30
    seen = [np.linalg.norm((shares @ s)[:, None] - (shares @ t)[None], axis=2).min() for s, t in zip(a, b)]
    found = checker.triangle_distances(a, b)
    assert (found <= np.array(seen) + 1e-12).all() and (found >= np.array(seen) - 0.25).all()
    assert (found == 0).any() and (found > 0.1).any()


def test_the_file_holds_what_the_job_found():
    event = played(job_of(*two_bones()))[0][-1]
    made = certificate.document(event["result"], event["arrays"])
    assert made["holds"] and made["gap"] == pytest.approx(0.001)
    assert made["intervals"] == [[0, 0, 1, 0.0, 1.0, 0.001]]
    assert made["bodies"][1]["head"] == pytest.approx([0, 0.5, 0]) and made["bodies"][1]["rest"] == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    vertices = checker._Design(made).meshes[0]
    assert vertices.max() == pytest.approx(struct.unpack("<f", struct.pack("<f", 0.05))[0])
