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
_complete = []  # not empty: all of the add-on is registered, not only the word that NumPy is missing


def _run_command(argv):
    from . import cli

    return cli.main(argv)


def register():
    import bpy

    from .bridge import system_python

    if system_python.numpy_is_missing():
        from .ui import without_numpy

        without_numpy.register(__package__)
    else:
        _register_all()
    if hasattr(bpy.utils, "register_cli_command"):
        _command.append(bpy.utils.register_cli_command("transformables", _run_command))


def _register_all():
    from . import stages, ui

    ui.register_settings(__package__)
    stages.register()
    ui.register_jobs()
    _complete.append(True)


def unregister():
    import bpy

    while _command:
        bpy.utils.unregister_cli_command(_command.pop())
    if _complete:
        _complete.clear()
        _unregister_all()
    else:
        from .ui import without_numpy

        without_numpy.unregister()


def _unregister_all():
    from . import stages, ui

    ui.unregister_jobs()
    stages.unregister()
    ui.unregister_settings()
