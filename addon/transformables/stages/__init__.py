# SPDX-License-Identifier: GPL-3.0-or-later
"""One folder a stage, each with the same names: properties, operators, panel. The order is that of the work."""

import bpy


def _modules():
    from ..ui import panel
    from . import character, embedding, finishing, folding, segmentation, target

    return panel, (character, target, embedding, segmentation, folding, finishing)


def register():
    from ..ui import job_operator, settings

    panel, rooms = _modules()
    for room in rooms:
        for cls in room.properties.CLASSES:
            bpy.utils.register_class(cls)
    settings.register()
    for owner in (job_operator, panel, *(module for room in rooms for module in (room.operators, room.panel))):
        for cls in owner.CLASSES:
            bpy.utils.register_class(cls)


def unregister():
    from ..ui import job_operator, settings

    panel, rooms = _modules()
    for owner in reversed((job_operator, panel, *(module for room in rooms for module in (room.operators, room.panel)))):
        for cls in reversed(owner.CLASSES):
            bpy.utils.unregister_class(cls)
    settings.unregister()
    for room in reversed(rooms):
        for cls in reversed(room.properties.CLASSES):
            bpy.utils.unregister_class(cls)
