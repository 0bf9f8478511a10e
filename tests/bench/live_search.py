# SPDX-License-Identifier: GPL-3.0-or-later
"""A search for folded poses as an artist at the window meets it: how often it shows where it is, and how soon it ends when asked to.

    blender -b FILE.blend --factory-startup --python tests/bench/live_search.py -- [--json OUT] [--seconds S ...]

FILE holds one armature and one mesh. Searches at default options (Find Folded Pose, then Explore) run in a worker and are stopped S seconds after their first pose, as Esc does it. Wall time, the only
one here: on a busy machine all of it is longer, so the load average is told. What the window adds is measured in tests/gui/test_live.py.
"""
import argparse
import json
import os
import pathlib
import sys
import time

import bpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "addon"))

from transformables.bridge import design  # noqa: E402  (its folder is put on the path just above)
from transformables.core.job import Job  # noqa: E402
from transformables.core.options import DesignOptions  # noqa: E402

LONGEST_WAIT = 0.01  # seconds between polls


def searched(fields, seconds):
    """(times of the poses that came, seconds from the request to end until the answer, its kind) of a search that is stopped so long after its first pose."""
    found = [next(o for o in bpy.data.objects if o.type == kind) for kind in ("ARMATURE", "MESH")]
    message, arrays = design.gather(*found, DesignOptions(), until="embedding", **fields)
    job = Job(message, arrays)
    job.start()
    poses, asked = [], None
    while True:
        job.wait(LONGEST_WAIT)
        for event in job.poll():
            if event["kind"] == "pose":
                poses.append(time.monotonic())
            if event["kind"] in ("result", "error"):
                return poses, time.monotonic() - (asked or float("nan")), event["kind"]
        if asked is None and poses and time.monotonic() - poses[0] > seconds:
            asked = time.monotonic()
            job.stop()


def row(name, fields, moments):
    """What the worst of the searches that are stopped at these moments came to. @raises SystemExit when one gave no pose"""
    rates, gaps, answers = [], [], []
    for seconds in moments:
        poses, answer, kind = searched(fields, seconds)
        if kind != "result":
            raise SystemExit(f"live_search: the search that was stopped after {seconds} s gave no pose")
        rates.append((len(poses) - 1) / (poses[-1] - poses[0]))
        gaps.append(max(b - a for a, b in zip(poses, poses[1:])))
        answers.append(answer)
    return {"search": name, "stopped_after": list(moments), "poses_a_second": min(rates), "longest_pause_ms": 1e3 * max(gaps),
            "answers_ms": [1e3 * a for a in answers], "load": os.getloadavg()[0]}


def main():
    parser = argparse.ArgumentParser(prog="live_search")
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, nargs="+", default=[0.5, 1, 2, 4, 8])
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    explore = {"explore": {"count": 5, "least_difference": 0.15}}
    rows = [row(name, fields, options.seconds) for name, fields in (("Find Folded Pose", {}), ("Explore", explore))]
    for found in rows:
        print(json.dumps(found), flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows))


main()
