# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Blender runs a Python without NumPy.

Debian's Blender takes its Python's folders from the first python3.11 on PATH. With pyenv, conda or a virtual environment there,
the system's packages are out of its sight. This module works without NumPy.
"""
import contextlib
import os
import subprocess
import sys

import bpy

SYSTEM_FOLDER = "/usr/bin"
STARTED_AGAIN = "TRANSFORMABLES_STARTED_AGAIN"  # in the environment of the second start: there is no third
ASK_SECONDS = 60


def numpy_is_missing():
    """Whether this Python can't import NumPy. A mere folder of that name, as Debian has beside it, is none."""
    try:
        from numpy import ndarray  # noqa: F401  (only whether it is there)
    except ImportError:
        return True
    return False


def advice():
    """What is wrong and what to do, in one line for the user."""
    return (f"Blender runs the Python in {sys.prefix}, which has no NumPy: start Blender with the folder of the system's python3 "
            f"first on PATH (PATH={SYSTEM_FOLDER}:$PATH blender), or install NumPy for that Python")


def start_again():
    """Puts the same Blender with the same words in this process's place, with the system's Python first on PATH.

    Comes back, having done nothing, where that would not help: in a window (work would be lost), in a start that is the second
    already, and where the system's Python has no NumPy either or is of another version.
    """
    headless, program, own_folder = _app()
    if not headless or not program or STARTED_AGAIN in os.environ or not _system_has_numpy():
        return
    environment = {**os.environ, STARTED_AGAIN: "1", "PATH": f"{SYSTEM_FOLDER}:{os.environ.get('PATH', '')}"}
    print(f"transformables: the Python in {sys.prefix} has no NumPy: starting Blender again with the one in {SYSTEM_FOLDER}",
          file=sys.stderr, flush=True)
    sys.stdout.flush()
    with contextlib.suppress(OSError):  # Blender won't come to tidying up; a folder that is not empty is left to the system
        os.rmdir(own_folder)
    os.execve(program, sys.argv, environment)


def _app():
    """(whether there is no window, this Blender's program or nothing, its folder for temporary files)."""
    return bpy.app.background, bpy.app.binary_path, bpy.app.tempdir


def _system_has_numpy():
    """Whether the system's Python is of our version and has NumPy."""
    ask = [os.path.join(SYSTEM_FOLDER, "python3"), "-I", "-c", "import sys; from numpy import ndarray; print(*sys.version_info[:2])"]
    try:
        answer = subprocess.run(ask, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=ASK_SECONDS)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return answer.returncode == 0 and answer.stdout.split() == [str(n) for n in sys.version_info[:2]]
