# SPDX-License-Identifier: GPL-3.0-or-later
"""Ends jobs when another file is loaded: the scene that they are for goes away. Undo takes the drawn pose away."""

import bpy
from bpy.app.handlers import persistent

from . import block_overlay, overlays, session


@persistent
def _before_load(*_):
    session.end()
    session.forget()
    overlays.clear()
    block_overlay.clear()


@persistent
def _after_undo(*_):
    block_overlay.clear()
    if session.current() is None:
        overlays.clear()  # the pose that it shows may be the one that was undone


def register():
    bpy.app.handlers.load_pre.append(_before_load)
    bpy.app.handlers.undo_post.append(_after_undo)


def unregister():
    bpy.app.handlers.undo_post.remove(_after_undo)
    bpy.app.handlers.load_pre.remove(_before_load)
