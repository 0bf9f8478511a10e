# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui.job_operator import JobOperator


class TRANSFORMABLES_OT_plan_fold(JobOperator, bpy.types.Operator):
    """Find the order in which the joints turn, starting from the folded pose that was found"""

    bl_idname = "transformables.plan_fold"
    bl_label = "Plan the Fold"
    bl_options = {"UNDO"}
    until = "folding"
    uses_stored = ("embedding",)


CLASSES = (TRANSFORMABLES_OT_plan_fold,)
