# SPDX-License-Identifier: GPL-3.0-or-later
"""Dividing the target among the bones."""
