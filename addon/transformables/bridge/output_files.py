# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that the headless command writes: checked before the work, written all at once after it."""
import os
import tempfile
import time

import bpy

from ..core import certificate as certificates
from ..core import report as reports
from ..core.options import UserError
from . import printing


class OutputFiles:
    """`wanted`: {kind ("output", "report", "certificate"): path as the user gave it, or None}; `parts`: a folder for printing, or None.

    Raises UserError where something can't be written, as far as that can be known before the work.
    """

    def __init__(self, wanted, parts):
        self.paths = {kind: _absolute(path) for kind, path in wanted.items() if path is not None}
        self.parts = None if parts is None else _absolute(parts)
        if self.parts is not None:
            self._check_parts()
        elif not self.paths:
            raise UserError("nothing to write: give --output OUT.blend, --report OUT.json, or both")
        for kind, path in self.paths.items():
            same = [f"--{k}" for k, p in self.paths.items() if p == path]
            if len(same) > 1:
                raise UserError(f"{same[0]} and {same[1]} are the same file {path}: give two")
        for kind, path in self.paths.items():
            _check(kind, path)

    def _check_parts(self):
        """The folder is made at the end; that it can be made is found out now."""
        above = self.parts
        while not os.path.lexists(above):
            above = os.path.dirname(above)
        if not os.path.isdir(above) or not os.access(above, os.W_OK | os.X_OK):
            raise UserError(f"--parts {self.parts} can't be written: give a folder that you may write to")

    def write(self, report, event, rig, began):
        """All files beside their places first, then all into place: whoever looks finds the old or the new, never half. `event` is the job's result;
        the report tells how long all took since `began` (time.perf_counter())."""
        ready = {}
        try:
            if "output" in self.paths:
                ready["output"] = _temporary(self.paths["output"])
                os.unlink(ready["output"])  # Blender would keep the empty file as a backup
                bpy.ops.wm.save_as_mainfile(filepath=ready["output"], copy=True, check_existing=False)
            report["seconds"]["total"] = time.perf_counter() - began
            if "report" in self.paths:
                ready["report"] = _temporary(self.paths["report"])
                reports.write(ready["report"], report)
            if "certificate" in self.paths:
                ready["certificate"] = _temporary(self.paths["certificate"])
                certificates.write(ready["certificate"], certificates.document(event["result"], event["arrays"]))
            if self.parts is not None:
                printing.export(rig, self.parts)
                if rig.get(printing.PINS):
                    printing.export(rig, self.parts, "assembled")
            for kind in list(ready):
                os.replace(ready[kind], self.paths[kind])
                del ready[kind]
        except (OSError, RuntimeError) as error:
            raise UserError(f"the design could not be written: {' '.join(str(error).split())}") from error
        finally:
            for path in ready.values():
                if os.path.exists(path):
                    os.unlink(path)


def _absolute(path):
    return os.path.abspath(bpy.path.abspath(path))


def _check(kind, path):
    if os.path.isdir(path):
        raise UserError(f"--{kind} {path} is a folder: give a file's name")
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise UserError(f"--{kind} {path} is write-protected: give another name")
    try:
        os.unlink(_temporary(path))
    except OSError as error:
        raise UserError(f"--{kind} {path} can't be written ({error.strerror}): give a folder that exists "
                        "and that you may write to") from None


def _temporary(path):
    """A new empty file beside `path`, of the same kind."""
    folder, name = os.path.split(path)
    base, ending = os.path.splitext(name)
    handle, temporary = tempfile.mkstemp(prefix=f".{base}-", suffix=ending, dir=folder)
    os.close(handle)
    os.chmod(temporary, 0o666 & ~_umask())
    return temporary


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
