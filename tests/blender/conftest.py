# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets tests import the add-on's package and what the plain tests share."""
import faulthandler
import pathlib
import sys

import bpy
import pytest

HANGS_AFTER_SECONDS = 600
TESTS = pathlib.Path(__file__).resolve().parents[1]
for folder in (TESTS.parent / "addon", TESTS / "addon", TESTS / "blender"):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))


@pytest.fixture
def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield bpy.context.scene


@pytest.fixture(autouse=True)
def a_test_that_hangs_says_where_and_ends():
    """No test may hold the gate up for ever; what every thread was doing goes to standard error, and the run fails."""
    faulthandler.dump_traceback_later(HANGS_AFTER_SECONDS, exit=True, file=sys.__stderr__)
    yield
    faulthandler.cancel_dump_traceback_later()
