# SPDX-License-Identifier: GPL-3.0-or-later
"""A design job in a worker process, seen from Blender: start, poll, cancel. No threads, and no call waits.

Events that `poll` gives, in order:
    {"kind": "progress", "stage", "fraction" (of the stage, 0 to 1), "note"}
    {"kind": "pose", "root", "angles", "morphology", "terms", "value", "points"}    value: what poses rank by; points: world space, two a line
    {"kind": "warning", "text"}
    {"kind": "result", "result": dict, "arrays": {name: (typecode, bytes)}}        the last one
    {"kind": "error", "type", "text", "details" (sometimes)}                      or this is the last one
After `cancel` the last event is always an error of type Cancelled; after `stop` it is that or the result with the best so far.
An error's type is Cancelled, InvalidInput, Infeasible, OutOfMemory, WorkerDied, NoWorker, or a fault's class name.
"""
from collections import deque
import os
import select
import shutil
import signal
import subprocess
import sys
import time

from . import messages

CANCEL_GRACE_SECONDS = 0.5
HELLO_SECONDS = 60.0       # Blender as a worker needs some on a busy machine
READ_BYTES = 1 << 20
READ_BUDGET = 64 << 20     # bytes a poll, so that a poll ends
WRITE_SECONDS = 0.004      # a poll, while the worker empties the pipe
PIPE_BYTES = 1 << 20
KEPT_STDERR = 4000
UNCHANGED = "nothing in your scene was changed"

_good_commands = {}  # module folder -> the command that worked, for this session


def native_dir():
    """Where the native module lies, beside this package."""
    return os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "native")


def worker_commands(module_dir):
    """Commands that may start a matching worker, best first: this process's Python, its namesakes, Blender itself."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "worker.py")
    name = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    pythons = [os.path.join(prefix, "bin", name) for prefix in (sys.prefix, sys.base_prefix)]
    pythons += [sys.executable, shutil.which(name), f"/usr/bin/{name}"]
    commands = []
    for python in pythons:
        if python and "python" in os.path.basename(python).lower() and os.access(python, os.X_OK):
            commands.append([python, "-I", "-B", script, "--", module_dir])
    blender = _blender_binary()
    if blender:
        commands.append([blender, "-b", "--factory-startup", "--python", script, "--", module_dir])
    unique = [c for i, c in enumerate(commands) if c not in commands[:i]]
    good = _good_commands.get(module_dir)
    return [good] + [c for c in unique if c != good] if good else unique


def _blender_binary():
    bpy = sys.modules.get("bpy")
    path = getattr(getattr(bpy, "app", None), "binary_path", "") if bpy else ""
    return path if path and os.access(path, os.X_OK) else None


class Job:
    """One job: a message and arrays as core/pipeline.py wants them. Used once."""

    def __init__(self, message, arrays, module_dir=None, commands=None):
        self._pieces = messages.encode(message, arrays)  # tells bad arrays at once
        self._module_dir = module_dir or native_dir()
        self._commands = deque(commands if commands is not None else worker_commands(self._module_dir))
        self._tried = []
        self._process = None
        self._state = "new"  # new, greeting, working, done
        self._to_write = deque()
        self._cancel_at = self._stop_at = None
        self._stderr = ""
        self._events = []

    @property
    def running(self):
        return self._state in ("greeting", "working")

    @property
    def pid(self):
        """Of the worker process; None when there is none."""
        return self._process.pid if self._process else None

    def start(self):
        if self._state != "new":
            raise RuntimeError("a job can be started once")
        self._start_next()

    def poll(self):
        """What happened since the last call; to be called until an error or the result has come."""
        if self.running:
            self._write()
            self._read()
            self._check_end()
        events, self._events = self._events, []
        return events

    def wait(self, seconds):
        """For callers with nothing else to do: returns when there may be something to poll, or time is up."""
        if self.running and os.name != "nt":
            writers = [self._process.stdin] if self._to_write else []
            select.select([self._process.stdout, self._process.stderr], writers, [], seconds)
        elif self.running:
            time.sleep(seconds)

    def cancel(self):
        """Asks the worker to stop; `poll` kills it when it doesn't answer in time, and then gives the error event."""
        if self._state == "new":
            self._end(_error("Cancelled", f"cancelled; {UNCHANGED}"))
        if not self.running or self._cancel_at is not None:
            return
        self._cancel_at = time.monotonic()
        if self._state == "greeting" or self._to_write:  # it isn't listening yet
            self._kill()
            self._end(_error("Cancelled", f"cancelled; {UNCHANGED}"))
            return
        self._to_write.extend(memoryview(p) for p in messages.encode({"kind": "cancel"}))
        self._write()

    def stop(self):
        """Asks a search for a pose to end with the best that it has; what has nothing yet, or doesn't answer in time, is cancelled."""
        if self._state != "working" or self._to_write:
            self.cancel()
        elif self._stop_at is None:
            self._stop_at = time.monotonic()
            self._to_write.extend(memoryview(p) for p in messages.encode({"kind": "stop"}))
            self._write()

    def close(self):
        """Ends the worker now, whatever it does. Safe to call at any time, and more than once."""
        self._kill()
        self._state = "done"
        self._to_write.clear()

    def _start_next(self):
        """Starts the next candidate; a candidate is right when its module greets."""
        while self._commands:
            command = self._commands.popleft()
            self._tried.append(command[0])
            try:
                self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                                 stderr=subprocess.PIPE, bufsize=0)
            except OSError as error:
                self._stderr = str(error)
                continue
            self._command, self._state, self._started = command, "greeting", time.monotonic()
            self._reader = messages.FrameReader(skip_noise=True)
            for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
                _prepare_pipe(stream.fileno())
            return
        lines = self._stderr.strip().splitlines()
        self._end(_error("NoWorker", f"no Python that can load the add-on's module from {self._module_dir} was found "
                         f"(tried {', '.join(self._tried) or 'none'}): {lines[-1] if lines else 'it said nothing'}"))

    def _write(self):
        until = time.monotonic() + WRITE_SECONDS
        while self._to_write:
            try:
                written = os.write(self._process.stdin.fileno(), self._to_write[0][:READ_BYTES])
            except BlockingIOError:
                if time.monotonic() > until:
                    return
                select.select([], [self._process.stdin], [], WRITE_SECONDS / 4)
                continue
            except OSError:  # the worker is gone; _check_end tells
                self._to_write.clear()
                return
            self._to_write[0] = self._to_write[0][written:]
            if not self._to_write[0]:
                self._to_write.popleft()

    def _read(self):
        self._stderr = (self._stderr + _available(self._process.stderr, KEPT_STDERR * 16).decode(errors="replace"))[-KEPT_STDERR:]
        try:
            for message, arrays in self._reader.feed(_available(self._process.stdout, READ_BUDGET)):
                self._take(message, arrays)
                if not self.running:
                    return
        except messages.BadFrame as error:
            self._end(_error("WorkerDied", f"the worker process sent something unreadable ({error}); {UNCHANGED}"))

    def _take(self, message, arrays):
        kind = message.get("kind")
        if kind == "hello" and self._state == "greeting":
            self._state = "working"
            _good_commands[self._module_dir] = self._command
            self._to_write.extend(memoryview(piece) for piece in self._pieces if len(piece))
            self._pieces = []
            self._write()
        elif kind == "result":
            self._end({**message, "arrays": arrays})
        elif kind == "error":
            self._end(message)
        elif self._state == "working":
            self._events.append(message)

    def _check_end(self):
        if not self.running:
            return
        now = time.monotonic()
        asked_at = self._cancel_at if self._cancel_at is not None else self._stop_at
        if asked_at is not None and now - asked_at > CANCEL_GRACE_SECONDS:
            self._end(_error("Cancelled", f"cancelled; {UNCHANGED}"))
        elif self._process.poll() is not None:
            self._read()  # its last words
            if self.running:
                self._ended_early(self._process.returncode)
        elif self._state == "greeting" and now - self._started > HELLO_SECONDS:
            self._stderr = f"no answer within {HELLO_SECONDS:.0f} s"
            self._kill()
            self._start_next()

    def _ended_early(self, code):
        if self._state == "greeting":
            self._kill()
            self._start_next()
            return
        self._end({**_error("WorkerDied", f"the worker process ended ({_ending(code, self._stderr)}); {UNCHANGED}. "
                            "Try a lower resolution"), "details": self._stderr})

    def _end(self, event):
        # What crossed the cancel on its way, a result or a worker's death, is not wanted any more.
        if self._cancel_at is not None or event.get("type") == "Cancelled":
            event = _error("Cancelled", f"cancelled; {UNCHANGED}")
        self._events.append(event)
        self._state = "done"
        self._to_write.clear()
        self._kill()

    def _kill(self):
        process = self._process
        if process is None:
            return
        if process.poll() is None:
            process.kill()
        for stream in (process.stdin, process.stdout, process.stderr):
            stream.close()
        try:
            process.wait(0.02)
        except subprocess.TimeoutExpired:
            pass  # it is being ended: the system is still freeing its memory; subprocess collects it later


def _error(kind, text):
    return {"kind": "error", "type": kind, "text": text}


def _ending(code, stderr):
    if code >= 0:
        return f"exit code {code}"
    out_of_memory = -code == getattr(signal, "SIGKILL", 9) or "bad_alloc" in stderr or "memory" in stderr.lower()
    names = {getattr(signal, n, None): words for n, words in (
        ("SIGSEGV", "a crash in a library"), ("SIGABRT", "a library gave up"), ("SIGTERM", "ended from outside"))}
    return f"signal {-code}: {'probably out of memory' if out_of_memory else names.get(-code, 'ended from outside')}"


def _prepare_pipe(fd):
    os.set_blocking(fd, False)
    try:
        import fcntl
        fcntl.fcntl(fd, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    except (ImportError, AttributeError, OSError):
        pass  # only Linux has larger pipes; smaller ones are slower, not wrong


def _available(stream, budget):
    """All bytes that can be read without waiting."""
    pieces, total = [], 0
    while total < budget:
        try:
            data = os.read(stream.fileno(), READ_BYTES)
        except (BlockingIOError, ValueError):
            break
        if not data:
            break
        pieces.append(data)
        total += len(data)
    return b"".join(pieces)
