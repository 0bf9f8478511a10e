# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets tests import the add-on's package and what the plain tests share."""
import faulthandler
import pathlib
import sys

import bpy  # first: it makes addon_utils findable
import addon_utils
import pytest

HANGS_AFTER_SECONDS = 600
TESTS = pathlib.Path(__file__).resolve().parents[1]
for folder in (TESTS.parent / "addon", TESTS / "addon", TESTS / "blender"):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

import scenes  # noqa: E402  (found by the lines above)


@pytest.fixture
def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield bpy.context.scene


@pytest.fixture
def scene():
    """A snake and a box, with the add-on switched on and its panel set to a coarse grid."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert addon_utils.enable("transformables", default_set=True) is not None
    scenes.armature([(f"link{i}", f"link{i - 1}" if i else None, (0, i, 0), (0, i + 1, 0), 0, None) for i in range(3)], "Snake")
    _add_box()
    bpy.context.scene.transformables.target_stage.resolution = 24
    bpy.context.view_layer.update()
    yield bpy.context.scene
    addon_utils.disable("transformables", default_set=True)


@pytest.fixture
def stand_in(monkeypatch):
    """A native module that designs nothing but answers at once, where only the plumbing is tested."""
    from transformables.core import job
    monkeypatch.setattr(job, "native_dir", lambda: str(TESTS / "addon" / "stand_in"))


@pytest.fixture(autouse=True)
def a_test_that_hangs_says_where_and_ends():
    """No test may hold the gate up for ever; what every thread was doing goes to standard error, and the run fails."""
    faulthandler.dump_traceback_later(HANGS_AFTER_SECONDS, exit=True, file=sys.__stderr__)
    yield
    faulthandler.cancel_dump_traceback_later()


def _add_box():
    mesh = bpy.data.meshes.new("Box")
    corners = [(x, y, z) for x in (-1, 1) for y in (-2, 2) for z in (-1, 1)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Box", mesh))
