# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets tests import the add-on's package and what the plain tests share."""
import pathlib
import sys

import bpy
import pytest

TESTS = pathlib.Path(__file__).resolve().parents[1]
for folder in (TESTS.parent / "addon", TESTS / "addon", TESTS / "blender"):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))


@pytest.fixture
def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield bpy.context.scene
