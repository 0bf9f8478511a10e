# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators share that look at what the artist picked, before any design."""

from ..core.options import UserError
from . import fingerprint, session, settings


class CheckOperator:
    """Looks at the picked object of a stage, and keeps what it finds, in lines. A subclass names its stage and what to pick, and
    has `findings(context, obj)`, which gives the lines and raises UserError."""

    bl_options = {"UNDO"}
    stage = ""
    to_pick = ""

    @classmethod
    def poll(cls, context):
        if settings.picked(context.scene, cls.stage) is None:
            cls.poll_message_set(cls.to_pick)
            return False
        if session.current() is not None:
            cls.poll_message_set("A design is running: wait for it, or press Esc to cancel it")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        try:
            lines = self.findings(context, settings.picked(scene, self.stage))
        except UserError as error:
            session.last.error = str(error)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        group = getattr(scene.transformables, f"{self.stage}_stage")
        group.stored = "\n".join(lines)
        group.stored_for = fingerprint.take(scene, self.stage)
        return {"FINISHED"}
