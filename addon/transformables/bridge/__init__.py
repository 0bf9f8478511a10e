# SPDX-License-Identifier: GPL-3.0-or-later
"""The only code that turns Blender's data into arrays and back. `design` is the door: gather, and apply."""
