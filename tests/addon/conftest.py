# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets tests import the add-on's package: nothing of `core` needs Blender."""
import pathlib
import sys

ADDON = pathlib.Path(__file__).resolve().parents[2] / "addon"
if str(ADDON) not in sys.path:
    sys.path.insert(0, str(ADDON))
