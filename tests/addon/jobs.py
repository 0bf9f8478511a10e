# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of jobs share: a two-bone job, and a loop that polls as Blender's timer does."""
import pathlib
import struct
import sys
import time

from transformables.core import job as jobs
from transformables.core.options import DesignOptions

STAND_IN = str(pathlib.Path(__file__).resolve().parent / "stand_in")
WORKER = pathlib.Path(jobs.__file__).with_name("worker.py")
COMMAND = [sys.executable, "-I", "-B", str(WORKER), "--", STAND_IN]
IDENTITY = (1, 0, 0, 0, 1, 0, 0, 0, 1)


def two_bones(seed=0, until="finishing", triangles=4, **more):
    """(message, arrays): a root and an arm with one hinge."""
    message = {"kind": "design", "until": until, "options": DesignOptions(seed=seed).as_dict(),
               "names": {"character": "c", "target": "t"}, "target": {"floor": -1.0},
               "character": {"names": ["root", "arm"], "parents": [-1, 0], "hinges": [[], [(0, -1.5, 1.5)]]}, **more}
    points = struct.pack("<12d", *[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1])
    arrays = {"heads": ("d", struct.pack("<6d", 0, 0, 0, 0, 1, 0)), "tails": ("d", struct.pack("<6d", 0, 1, 0, 0, 2, 0)),
              "axes": ("d", struct.pack("<18d", *IDENTITY, *IDENTITY)), "rotation": ("d", struct.pack("<9d", *IDENTITY)),
              "vertices": ("d", points), "triangles": ("i", struct.pack("<3i", 0, 1, 2) * triangles)}
    return message, arrays


def job_of(message, arrays, commands=None):
    return jobs.Job(message, arrays, STAND_IN, commands=commands or [COMMAND])


def played(job, seconds=20.0, on_event=None):
    """All events of a job, and the longest time that a single poll took."""
    job.start()
    return polled(job, seconds, on_event)


def polled(job, seconds=20.0, on_event=None):
    events, slowest, began = [], 0.0, time.monotonic()
    while job.running or not events or events[-1]["kind"] not in ("result", "error"):
        assert time.monotonic() - began < seconds, f"no end after {seconds} s: {events[-3:]}"
        before = time.perf_counter()
        new = job.poll()
        slowest = max(slowest, time.perf_counter() - before)
        for event in new:
            events.append(event)
            if on_event:
                on_event(event)
        time.sleep(0.005)
    return events, slowest
