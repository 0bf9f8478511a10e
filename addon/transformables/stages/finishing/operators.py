# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui.job_operator import JobOperator


class TRANSFORMABLES_OT_design(JobOperator, bpy.types.Operator):
    """Design everything anew: fold the character into the target, make the parts, the rig and its animation"""

    bl_idname = "transformables.design"
    bl_label = "Design"
    bl_options = {"UNDO"}
    until = "finishing"


class TRANSFORMABLES_OT_finish(JobOperator, bpy.types.Operator):
    """Make the parts, the rig and its animation, starting from the folded pose and the fold path that were found"""

    bl_idname = "transformables.finish"
    bl_label = "Make Parts and Rig"
    bl_options = {"UNDO"}
    until = "finishing"
    uses_stored = ("embedding",)  # the path and the parts made to go with it are found again: seconds, and the same


CLASSES = (TRANSFORMABLES_OT_design, TRANSFORMABLES_OT_finish)
