# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui.job_operator import JobOperator


class TRANSFORMABLES_OT_segment(JobOperator, bpy.types.Operator):
    """Divide the target among the bones, starting from the folded pose that was found"""

    bl_idname = "transformables.segment"
    bl_label = "Divide Target into Parts"
    bl_options = {"UNDO"}
    until = "segmentation"
    uses_stored = ("embedding",)


CLASSES = (TRANSFORMABLES_OT_segment,)
