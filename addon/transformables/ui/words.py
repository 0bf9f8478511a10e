# SPDX-License-Identifier: GPL-3.0-or-later
"""Text in panels. Works without NumPy."""

import textwrap

PIXELS_A_LETTER = 6.4  # of Blender's interface font at its common size, on average
MARGIN_PIXELS = 62     # the panel's borders, the tabs and an icon


def labels(layout, context, text, icon="NONE"):
    """Text that may be longer than the sidebar is wide, on as many lines as it needs."""
    scale = context.preferences.system.ui_scale
    width = max(20, int((context.region.width / scale - MARGIN_PIXELS) / PIXELS_A_LETTER))
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, row in enumerate(textwrap.wrap(text, width) or [""]):
        column.label(text=row, icon=icon if i == 0 or icon == "NONE" else "BLANK1")
