# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tests of this folder inside Blender.

    blender -b --factory-startup --python tests/blender/run.py -- [pytest's arguments]
    python tests/blender/run.py [pytest's arguments]        in an environment with PyPI's bpy
"""
import os
import sys

import bpy
import pytest

HERE = os.path.dirname(os.path.abspath(__file__))

arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [] if bpy.app.binary_path else sys.argv[1:]
if not any(not a.startswith("-") and os.path.exists(a.split("::")[0]) for a in arguments):
    arguments.append(HERE)
code = pytest.main(["-p", "no:cacheprovider", *arguments])
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)  # Blender would exit 0
