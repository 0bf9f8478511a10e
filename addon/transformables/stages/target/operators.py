# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

from ...ui.job_operator import JobOperator


class TRANSFORMABLES_OT_check_target(JobOperator, bpy.types.Operator):
    """Check whether the target mesh can be filled, and repair what must be repaired; the mesh itself is not changed"""

    bl_idname = "transformables.check_target"
    bl_label = "Check Target"
    bl_options = {"UNDO"}
    until = "target"


CLASSES = (TRANSFORMABLES_OT_check_target,)
