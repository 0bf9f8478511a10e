# SPDX-License-Identifier: GPL-3.0-or-later
"""Ends jobs when another file is loaded: the scene that they are for goes away."""

import bpy
from bpy.app.handlers import persistent

from . import overlays, session


@persistent
def _before_load(*_):
    session.end()
    session.forget()
    overlays.clear()


def register():
    bpy.app.handlers.load_pre.append(_before_load)


def unregister():
    bpy.app.handlers.load_pre.remove(_before_load)
