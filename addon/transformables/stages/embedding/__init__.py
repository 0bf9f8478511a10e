# SPDX-License-Identifier: GPL-3.0-or-later
"""Folding the skeleton into the target."""
