# SPDX-License-Identifier: GPL-3.0-or-later
"""Designs transformables: a character that folds up into a target object.

Nothing here imports bpy at the top, so that `core` can be used (and tested) by a plain Python.
"""

bl_info = {
    "name": "Transformables",
    "author": "The Transformables authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Transformables",
    "description": "Design characters that fold up into an object",
    "category": "Rigging",
}

_command = []  # handle of the command-line command, where this Blender knows such a thing (4.2)


def _run_command(argv):
    from . import cli

    return cli.run(argv)


def register():
    import bpy

    from . import stages, ui

    ui.register_settings(__package__)
    stages.register()
    ui.register_jobs()
    if hasattr(bpy.utils, "register_cli_command"):
        _command.append(bpy.utils.register_cli_command("transformables", _run_command))


def unregister():
    import bpy

    from . import stages, ui

    while _command:
        bpy.utils.unregister_cli_command(_command.pop())
    ui.unregister_jobs()
    stages.unregister()
    ui.unregister_settings()
