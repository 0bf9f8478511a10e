# SPDX-License-Identifier: GPL-3.0-or-later
from . import operators, panel, properties

__all__ = ("operators", "panel", "properties")
