# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh that is folded into."""
