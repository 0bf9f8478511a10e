# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs in real worker processes. The native module is the stand-in: what is tested is the plumbing around it."""
import os
import pathlib
import signal
import sys
import time

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import jobs
from jobs import job_of, played, polled, two_bones
from stand_in import transformables_native as stand_in

SHORT_POLL = 0.25  # seconds; a poll takes milliseconds, but this machine may be busy


def gone(pid):
    """Whether a process has ended (or waits to be collected)."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def test_a_job_gives_a_line_a_stage_a_pose_and_its_result():
    events, slowest = played(job_of(*two_bones()))
    stages = [e["stage"] for e in events if e["kind"] == "progress"]
    assert list(dict.fromkeys(stages)) == ["character", "target", "embedding", "segmentation", "folding", "finishing"]
    assert [e["text"] for e in events if e["kind"] == "warning"] == ["2 vertices were welded"]
    pose = next(e for e in events if e["kind"] == "pose")
    assert len(pose["points"]) == 4 and len(pose["angles"]) == 1
    assert events[-1]["kind"] == "result"
    assert len(events[-1]["result"]["finishing"]["parts"]) == 2
    assert len(events[-1]["arrays"]["part_1_vertices"][1]) == 12 * 8
    assert slowest < SHORT_POLL


def test_large_arrays_reach_the_worker_without_a_dead_lock_and_without_holding_the_caller_up():
    message, arrays = two_bones()
    arrays["vertices"] = ("d", bytes(8 * 3 * 2_000_000))
    events, slowest = played(job_of(message, arrays))
    assert events[-1]["kind"] == "result"
    assert slowest < SHORT_POLL


def test_what_libraries_print_does_not_disturb_the_frames():
    events, _ = played(job_of(*two_bones(stand_in.NOISY)))
    assert events[-1]["kind"] == "result"


@pytest.mark.parametrize("behaviour", [stand_in.ANSWERS_SLOWLY, stand_in.DEAF])
def test_a_cancelled_job_ends_soon_whether_the_worker_answers_or_not(behaviour):
    job, told = job_of(*two_bones(behaviour)), {}

    def cancel_when_busy(event):
        if event.get("stage") == "embedding" and "at" not in told:
            before = time.perf_counter()
            job.cancel()
            told.update(at=time.monotonic(), took=time.perf_counter() - before, pid=job.pid)

    events, slowest = played(job, on_event=cancel_when_busy)
    assert events[-1]["type"] == "Cancelled"
    assert time.monotonic() - told["at"] < 1.5
    assert told["took"] < SHORT_POLL and slowest < SHORT_POLL
    time.sleep(0.1)
    assert gone(told["pid"])


@pytest.mark.parametrize("behaviour", [stand_in.ANSWERS_SLOWLY, stand_in.DEAF])
def test_a_search_that_is_stopped_before_it_has_a_pose_is_cancelled(behaviour):
    job, asked = job_of(*two_bones(behaviour, until="embedding")), []

    def stop_when_busy(event):
        if event.get("stage") == "embedding" and not asked:
            asked.append(time.monotonic())
            job.stop()

    events, slowest = played(job, on_event=stop_when_busy)
    assert events[-1]["type"] == "Cancelled"
    assert time.monotonic() - asked[0] < 1.5 and slowest < SHORT_POLL


def test_a_job_can_be_cancelled_before_its_worker_listens():
    job = job_of(*two_bones(stand_in.DEAF))
    job.start()
    job.cancel()
    assert [e["type"] for e in job.poll()] == ["Cancelled"]
    assert not job.running


def test_a_job_that_never_started_can_be_cancelled():
    job = job_of(*two_bones())
    job.cancel()
    assert [e["type"] for e in job.poll()] == ["Cancelled"]


def test_closing_ends_the_worker_at_once_and_can_be_done_twice():
    job = job_of(*two_bones(stand_in.DEAF))
    job.start()
    while not any(e["kind"] == "progress" for e in job.poll()):
        time.sleep(0.01)
    pid = job.pid
    job.close()
    job.close()
    time.sleep(0.1)
    assert gone(pid) and not job.running and job.poll() == []


def test_a_worker_that_is_killed_is_an_error_in_words():
    events, _ = played(job_of(*two_bones(stand_in.KILLED)))
    assert events[-1]["type"] == "WorkerDied"
    assert "signal 9: probably out of memory" in events[-1]["text"]
    assert "nothing in your scene was changed" in events[-1]["text"]
    assert "\n" not in events[-1]["text"]


def test_a_worker_that_is_killed_from_outside_is_an_error_in_words():
    job = job_of(*two_bones(stand_in.DEAF))
    events, _ = played(job, on_event=lambda e: e.get("stage") == "embedding" and os.kill(job.pid, signal.SIGTERM))
    assert events[-1]["type"] == "WorkerDied" and "signal 15" in events[-1]["text"]


def test_a_library_that_gives_up_for_lack_of_memory_is_told_as_that():
    events, _ = played(job_of(*two_bones(stand_in.ABORTS)))
    assert events[-1]["type"] == "WorkerDied" and "out of memory" in events[-1]["text"]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's memory by address space")
def test_memory_can_be_limited_and_running_out_of_it_is_an_error_in_words():
    events, _ = played(job_of(*two_bones(stand_in.HUNGRY, memory_limit_mb=1024)))
    assert events[-1]["type"] == "OutOfMemory" and "lower resolution" in events[-1]["text"]


def test_input_that_the_native_module_refuses_is_one_line():
    events, _ = played(job_of(*two_bones(stand_in.BAD_INPUT)))
    assert events[-1] == {"kind": "error", "type": "InvalidInput", "text": "bone 'arm': its range is empty: give it one"}


def test_a_demand_that_no_design_meets_is_told_as_infeasible():
    events, _ = played(job_of(*two_bones(stand_in.INFEASIBLE)))
    assert events[-1]["type"] == "Infeasible"


def test_a_fault_in_the_worker_comes_with_its_traceback():
    events, _ = played(job_of(*two_bones(stand_in.FAULT)))
    assert events[-1]["type"] == "KeyError" and "Traceback" in events[-1]["details"]


def test_a_python_that_cannot_load_the_module_is_passed_over():
    wrong = [sys.executable, "-I", "-c", "import no_such_module"]
    events, _ = played(job_of(*two_bones(), commands=[["/no/such/python"], wrong, jobs.COMMAND]))
    assert events[-1]["kind"] == "result"


def test_without_any_matching_python_the_error_says_where_the_module_was_looked_for():
    events, _ = played(job_of(*two_bones(), commands=[[sys.executable, "-I", "-c", "import no_such_module"]]))
    assert events[-1]["type"] == "NoWorker"
    assert "no_such_module" in events[-1]["text"] and jobs.STAND_IN in events[-1]["text"]


def test_a_worker_that_speaks_another_language_is_an_error():
    speaker = [sys.executable, "-I", "-c", "import os; os.write(1, b'TFM1\\xff\\xff\\xff\\xff' + b'x' * 99); import time; time.sleep(9)"]
    events, _ = played(job_of(*two_bones(), commands=[speaker]))
    assert events[-1]["type"] == "WorkerDied" and "unreadable" in events[-1]["text"]


def test_a_worker_ends_when_the_one_who_started_it_goes_away():
    job = job_of(*two_bones(stand_in.ANSWERS_SLOWLY))
    job.start()
    while not any(e.get("note") == "slowly" for e in job.poll()):
        time.sleep(0.01)
    process = job._process
    process.stdin.close()
    process.stdout.close()
    assert process.wait(5) is not None
    process.stderr.close()


def test_a_job_is_started_once():
    job = job_of(*two_bones())
    job.start()
    with pytest.raises(RuntimeError):
        job.start()
    polled(job)
