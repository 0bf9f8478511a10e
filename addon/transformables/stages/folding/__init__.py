# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which the joints turn."""
