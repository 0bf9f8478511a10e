# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...core.options import UserError
from ...ui import blocks
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


class TRANSFORMABLES_OT_export_parts(bpy.types.Operator):
    """Write the parts as files for printing, in millimeters, at the size that the design was made for"""

    bl_idname = "transformables.export_parts"
    bl_label = "Export for Printing"

    directory: StringProperty(subtype="DIR_PATH", description="The folder to write to")
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})
    file_format: EnumProperty(
        name="Format", default="stl",
        items=(("assembled", "Assembled (3MF)", "One file with all parts in their places, as the timeline shows them now: for joints with pins, which are printed in place"),
               ("3mf", "Side by Side (3MF)", "One file with all parts beside each other"),
               ("stl", "Apart (STL)", "A file for each part, named after its bone")))

    @classmethod
    def poll(cls, context):
        if blocks.rig_of(context.scene) is None:
            cls.poll_message_set("There is no design in the scene yet")
            return False
        return True

    def invoke(self, context, event):
        from ...bridge import printing

        if blocks.rig_of(context.scene).get(printing.PINS):
            self.file_format = "assembled"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        from ...bridge import printing

        if not self.directory:
            self.report({"ERROR"}, "No folder was chosen to write the parts to")
            return {"CANCELLED"}
        try:
            names = printing.export(blocks.rig_of(context.scene), bpy.path.abspath(self.directory), self.file_format)
        except UserError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(names)} file{'s' if len(names) > 1 else ''} written to {self.directory}")
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_design, TRANSFORMABLES_OT_finish, TRANSFORMABLES_OT_export_parts)
