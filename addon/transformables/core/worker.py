# SPDX-License-Identifier: GPL-3.0-or-later
"""The worker process: reads one job from its standard input, does it, streams what happens to its standard output.

    python -I -B worker.py -- MODULE_DIR      or: blender -b --factory-startup --python worker.py -- MODULE_DIR

Standard output carries frames only: what libraries print goes to standard error. The process ends with its job, on
a cancel frame, on a stop frame (a search for a pose then gives its best so far), and when the other side goes away.
"""
import os
import signal
import sys
import time
import traceback

if __name__ == "__main__":
    sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from core import messages, pipeline  # noqa: E402  (the path is set for a process of our own)
from core.options import UserError  # noqa: E402

PROGRESS_SECONDS = 1 / 20  # between events of one kind, at least
POSE_SECONDS = 1 / 30
LISTEN_SECONDS = 1 / 100
READ_BYTES = 1 << 20


class Channel:
    """The two pipes to the process that started us."""

    def __init__(self, read_fd, write_fd):
        self._read_fd, self._write_fd = read_fd, write_fd
        self._reader = messages.FrameReader()
        self._frames = []

    @classmethod
    def from_standard_streams(cls):
        """Keeps both pipes to ourselves: from now on standard output is standard error, standard input is empty."""
        sys.stdout.flush()
        read_fd, write_fd = os.dup(0), os.dup(1)
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)
        return cls(read_fd, write_fd)

    def send(self, message, arrays=None):
        for piece in messages.encode(message, arrays):
            view = memoryview(piece)
            while view:
                view = view[os.write(self._write_fd, view):]

    def receive(self):
        """The next frame; waits for it. @raises EOFError when the other side is gone"""
        while not self._frames:
            self._read()
        return self._frames.pop(0)

    def asked_to_end(self):
        """"cancel" when that frame has come or the other side is gone, "stop" when that frame has, else "". Does not wait."""
        try:
            while not self._frames and _readable(self._read_fd):
                self._read()
        except EOFError:
            return "cancel"
        kind = self._frames[0][0].get("kind") if self._frames else ""
        return kind if kind in ("cancel", "stop") else ""

    def _read(self):
        data = os.read(self._read_fd, READ_BYTES)
        if not data:
            raise EOFError
        self._frames += self._reader.feed(data)


def _readable(fd):
    if os.name == "nt":
        return _readable_on_windows(fd)
    import select
    return bool(select.select([fd], [], [], 0)[0])


def _readable_on_windows(fd):
    """Pipes know no select there; a broken pipe counts as readable: reading it then tells of the end."""
    import ctypes
    import msvcrt
    waiting = ctypes.c_ulong(0)
    alive = ctypes.windll.kernel32.PeekNamedPipe(msvcrt.get_osfhandle(fd), None, 0, None, ctypes.byref(waiting), None)
    return not alive or waiting.value > 0


class Teller:
    """Streams a job's events, thinned out, and listens for a cancel meanwhile."""

    def __init__(self, channel):
        self._channel = channel
        self._last = {"progress": 0.0, "pose": 0.0, "listen": 0.0}
        self._end = ""

    def progress(self, stage, fraction, note=""):
        if self._due("listen", LISTEN_SECONDS):
            self._end = self._end or self._channel.asked_to_end()
        # A stage's first and last word are never left out: whoever listens can count on a line a stage.
        if self._due("progress", PROGRESS_SECONDS) or fraction in (0.0, 1.0):
            self._channel.send({"kind": "progress", "stage": stage, "fraction": float(fraction), "note": str(note)})
        return not self._end

    def enough(self):
        """Whether what was found so far is wanted, when `progress` has said to end."""
        return self._end == "stop"

    def pose(self, fields):
        if self._due("pose", POSE_SECONDS):
            self._channel.send({"kind": "pose", **fields})

    def warning(self, text):
        self._channel.send({"kind": "warning", "text": str(text)})

    def _due(self, what, seconds):
        now = time.monotonic()
        if now - self._last[what] < seconds:
            return False
        self._last[what] = now
        return True


def do_job(channel):
    """Receives a job, does it, sends its result or its error."""
    job, arrays = channel.receive()
    if job.get("memory_limit_mb"):
        _limit_memory(job["memory_limit_mb"])
    try:
        result, result_arrays = pipeline.run(job, arrays, Teller(channel))
        message = {"kind": "result", "result": result}
    except BrokenPipeError:
        raise
    except Exception as error:  # whatever it is crosses to the other side, where it is told to the user
        message, result_arrays = error_message(error), None
    channel.send(message, result_arrays)


def error_message(error):
    kinds = {cls.__name__ for cls in type(error).__mro__}
    if "Cancelled" in kinds:
        return {"kind": "error", "type": "Cancelled", "text": "cancelled"}
    if isinstance(error, UserError) or "InvalidInput" in kinds:
        return {"kind": "error", "type": "InvalidInput", "text": _line(error)}
    if "Infeasible" in kinds:
        return {"kind": "error", "type": "Infeasible", "text": _line(error)}
    if isinstance(error, MemoryError) or "bad_alloc" in str(error):
        return {"kind": "error", "type": "OutOfMemory",
                "text": "there is not enough memory for this design; nothing in your scene was changed. Try a lower resolution"}
    details = "".join(traceback.format_exception(type(error), error, error.__traceback__))
    return {"kind": "error", "type": type(error).__name__, "details": details,
            "text": f"a fault in the add-on: {type(error).__name__}: {_line(error)}"}


def _line(error):
    return " ".join(str(error).split())


def _limit_memory(megabytes):
    import resource
    limit = int(megabytes) << 20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def main(arguments):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; whoever started us decides
    channel = Channel.from_standard_streams()
    sys.path.insert(0, arguments[0])
    import transformables_native
    channel.send({"kind": "hello", "native_version": str(transformables_native.version), "python": sys.executable})
    do_job(channel)


if __name__ == "__main__":
    status = 1
    try:
        main(sys.argv[sys.argv.index("--") + 1:])
        status = 0
    except (EOFError, BrokenPipeError):
        status = 0  # nobody listens any more
    except BaseException:
        traceback.print_exc()
    finally:
        # No teardown: libraries' exit handlers have nothing to save, and Blender would greet on its way out.
        sys.stderr.flush()
        os._exit(status)
