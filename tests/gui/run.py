# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays the scenarios of all test_*.py of this folder, or those named, in a real window. Run by scripts/gui_test.sh.

    blender --factory-startup --enable-event-simulate --python tests/gui/run.py -- [scenario ...]
"""
import glob
import importlib
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), "addon")]

import driver  # noqa: E402  (its folder is put on the path just above)


def scenarios():
    files = sorted(glob.glob(os.path.join(HERE, "test_*.py")))
    return [s for file in files for s in importlib.import_module(os.path.splitext(os.path.basename(file))[0]).SCENARIOS]


def chosen():
    there = scenarios()
    wanted = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    unknown = [name for name in wanted if name not in {s.__name__ for s in there}]
    if unknown:
        print(f"no such scenario: {', '.join(unknown)}; there are: {', '.join(s.__name__ for s in there)}", flush=True)
        os._exit(2)
    return [s for s in there if not wanted or s.__name__ in wanted]


driver.run(chosen())
