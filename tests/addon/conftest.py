# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets tests import the add-on's package: nothing of `core` needs Blender."""
import pathlib
import sys

import pytest

ADDON = pathlib.Path(__file__).resolve().parents[2] / "addon"
if str(ADDON) not in sys.path:
    sys.path.insert(0, str(ADDON))


@pytest.fixture
def native(monkeypatch):
    """The stand-in in the native module's place, with nothing noted yet."""
    monkeypatch.syspath_prepend(str(ADDON.parent / "tests" / "addon" / "stand_in"))
    monkeypatch.delitem(sys.modules, "transformables_native", raising=False)
    import transformables_native
    transformables_native.calls.clear()
    transformables_native.searches.clear()
    transformables_native.transfers.clear()
    transformables_native.budgets.clear()
    yield transformables_native
    sys.modules.pop("transformables_native")
