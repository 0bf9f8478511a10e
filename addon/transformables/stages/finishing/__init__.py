# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts, rig and animation; and Design, which does it all."""
