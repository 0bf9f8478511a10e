# SPDX-License-Identifier: GPL-3.0-or-later
"""One folder a stage, each with the same names: properties, operators, panel. The order is that of the work."""

import importlib

import bpy

ORDER = ("character", "target", "embedding", "segmentation", "folding", "finishing")


def _modules(kind):
    return [importlib.import_module(f".{stage}.{kind}", __name__) for stage in ORDER]


def _properties():
    return [cls for module in _modules("properties") for cls in module.CLASSES]


def _operators_and_panels():
    from ..ui import job_operator, panel, presets

    return [cls for module in (job_operator, presets, panel, *_modules("operators"), *_modules("panel")) for cls in module.CLASSES]


def register():
    from ..ui import settings

    for cls in _properties():
        bpy.utils.register_class(cls)
    settings.register()
    for cls in _operators_and_panels():
        bpy.utils.register_class(cls)


def unregister():
    from ..ui import settings

    for cls in reversed(_operators_and_panels()):
        bpy.utils.unregister_class(cls)
    settings.unregister()
    for cls in reversed(_properties()):
        bpy.utils.unregister_class(cls)
