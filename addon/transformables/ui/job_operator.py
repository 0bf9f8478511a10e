# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a design, or a part of it, in a worker process while Blender stays usable.

Each stage's operator is a small class on top of `JobOperator`. No 'REGISTER': the redo panel would run the job again.
With 'UNDO' Blender pushes one undo step when the operator finishes, and none when it is cancelled; so nothing in the
.blend may change before the result is there.
"""

import time

import bpy

from ..core.options import DesignOptions, UserError
from . import overlays, preferences, results, session, settings, steering

POLL_SECONDS = 0.05
ANSWER_SECONDS = 0.08  # a search that is ended answers much sooner, but for a very busy machine


def options_of(scene):
    """The scene's settings as the program's options. @raises UserError"""
    s = scene.transformables
    character, target, embedding, folding, finishing = s.character_stage, s.target_stage, s.embedding_stage, s.folding_stage, s.finishing_stage
    options = DesignOptions(
        resolution=target.resolution, seed=embedding.seed, symmetry=embedding.symmetry,
        simplify=str(character.simplify_count) if character.simplify == "count" else character.simplify,
        fit=character.fit, proportions=embedding.proportions, size_mm=round(target.size_mm, 4),
        clearance_mm=round(finishing.clearance_mm, 4), style=finishing.style, wall_mm=round(finishing.wall_mm, 4),
        transfer=s.segmentation_stage.transfer, hinges=finishing.hinges,
        frames=folding.frames, loop=folding.loop, together=folding.together, fold_seconds=round(folding.seconds, 3), threads=preferences.get().threads)
    options.validate()
    return options


def objects_of(running):
    """The scene, character and target that a job is for, looked up by name. @raises UserError when one is gone"""
    scene = bpy.data.scenes.get(running.scene)
    if scene is None:
        raise UserError(f"The scene '{running.scene}' was deleted or renamed while its design was running: undo that, and run again")
    found = [scene.objects.get(name) for name in (running.character, running.target)]
    for name, obj in zip((running.character, running.target), found):
        if obj is None:
            raise UserError(f"'{name}' was deleted or renamed while its design was running: undo that, and run again")
    return scene, *found


class JobOperator:
    """What all operators share that start a worker. A subclass says how far to go and what to start from."""

    bl_options = {"UNDO"}
    until = "finishing"
    from_guide = False
    gives_way = False
    uses_stored = ()  # of "embedding" and "folding": stored results to start from when they still fit

    def more_fields(self, context, character):
        """What else a subclass wants in its job: keyword arguments of `gather`. @raises UserError"""
        return {}

    @classmethod
    def poll(cls, context):
        if session.current() is not None:
            cls.poll_message_set("A design is running already: wait for it, or press Esc to cancel it")
            return False
        problem = settings.missing(context.scene)
        if problem:
            cls.poll_message_set(problem)
            return False
        return True

    def invoke(self, context, event):
        if not self._begin(context):
            return {"CANCELLED"}
        manager, running = context.window_manager, session.current()
        running.timer = manager.event_timer_add(POLL_SECONDS, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        _show_progress(running)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        """Without a user at the window (a script's call): runs to the end before it returns."""
        if not self._begin(context):
            return {"CANCELLED"}
        while True:
            outcome = self._step(context)
            if outcome:
                return outcome
            time.sleep(POLL_SECONDS)

    def modal(self, context, event):
        if session.current() is not self._running:
            return {"CANCELLED"}  # ended from outside: a file was loaded, or the add-on is being disabled
        if event.type == "ESC" and event.value == "PRESS":
            session.ask_to_end(self._running)
            return self._answer(context) or {"PASS_THROUGH"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        return self._step(context) or {"PASS_THROUGH"}

    def _answer(self, context):
        """The outcome, once the job was asked to end, waited for a moment: by the timer it would come after a redraw or two, which may take longer."""
        until = time.monotonic() + ANSWER_SECONDS
        while True:
            outcome, left = self._step(context), until - time.monotonic()
            if outcome or left <= 0:
                return outcome
            self._running.job.wait(min(left, POLL_SECONDS))

    def cancel(self, context):
        """Blender calls this when it ends the operator itself, as when the window closes."""
        if session.current() is self._running:
            session.end()
            overlays.clear()

    def _begin(self, context):
        """Reads the scene and starts the worker; tells the user when it can't."""
        from ..bridge import design
        from ..core.job import Job

        scene = context.scene
        session.forget()
        overlays.clear()
        try:
            character, target = settings.picked(scene, "character"), settings.picked(scene, "target")
            _leave_edit_mode(context)
            stored, more = results.stored(scene, self.uses_stored), self.more_fields(context, character)
            message, arrays = design.gather(character, target, options_of(scene), until=self.until, steering=steering.of(scene),
                                            edits=settings.edits(scene), **stored, **more)
            job = Job(message, arrays)
            job.start()
        except UserError as error:
            self._tell_error(str(error))
            return False
        self._running = session.Running(job=job, until=self.until, scene=scene.name, character=character.name, target=target.name,
                                        warnings=list(message.get("warnings", ())),
                                        fingerprints=results.take_fingerprints(scene, self.until), from_guide=self.from_guide, gives_way=self.gives_way)
        session.begin(self._running)
        return True

    def _step(self, context):
        """Takes what the worker has sent. Gives the operator's outcome, or None while the work goes on."""
        running, outcome = self._running, {"CANCELLED"}
        try:
            if running.cancel_wanted:
                self.report({"INFO"}, "Cancelled: nothing was changed")
                session.last.summary = "Cancelled"
            else:
                outcome = self._take_events(context)
        except UserError as error:
            self._tell_error(str(error))
        finally:
            # Also when something unforeseen is on its way up: a job without an operator would never end.
            if outcome:
                session.end()
                if outcome == {"CANCELLED"}:
                    overlays.clear()
        return outcome

    def _take_events(self, context):
        running = self._running
        objects_of(running)
        for event in running.job.poll():
            kind = event["kind"]
            if kind == "error" and event["type"] == "Cancelled":
                running.cancel_wanted = True
                return None  # the next step ends it
            if kind == "error":
                raise UserError(event["text"])
            if kind == "result":
                self._take_result(context, event)
                return {"FINISHED"}
            if kind == "progress":
                running.stage, running.fraction, running.note = event["stage"], event["fraction"], event["note"]
            elif kind == "warning" and event["text"] not in running.warnings:
                running.warnings.append(event["text"])
            elif kind == "pose":
                results.show_pose(event)
        if not running.job.running:
            raise UserError("The worker process ended without a result: save your work, and run again")
        _show_progress(running)
        return None

    def _take_result(self, context, event):
        running = self._running
        scene, character, target = objects_of(running)
        with context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
            _leave_edit_mode(bpy.context)
            summary = results.keep(bpy.context, running, event["result"], event["arrays"], character, target, options_of(scene))
        collisions = results.collisions_left(event["result"])
        session.last.warnings = ([collisions] if collisions else []) + running.warnings
        session.last.summary = summary
        self.report({"WARNING" if collisions else "INFO"}, summary)

    def _tell_error(self, text):
        session.last.error = text
        self.report({"ERROR"}, text)
        session.redraw()


def _leave_edit_mode(context):
    """Data that is being edited is not in its object yet, and results are made in Object Mode."""
    if context.mode != "OBJECT" and context.view_layer.objects.active is not None:
        bpy.ops.object.mode_set(mode="OBJECT")


def _show_progress(running):
    now = time.monotonic()
    if bpy.app.background or now - running.drawn < session.REDRAW_SECONDS:
        return
    running.drawn = now
    bpy.context.window_manager.progress_update(100 * running.fraction)
    for window in bpy.context.window_manager.windows:
        window.workspace.status_text_set(f"{session.line()}   {100 * running.fraction:.0f}%   ({'Esc: keep the best' if running.until == 'embedding' else 'Esc: cancel'})")
    session.redraw()


class TRANSFORMABLES_OT_cancel(bpy.types.Operator):
    """Stop the design that is running. The scene stays as it is; a search for a folded pose keeps the best so far"""

    bl_idname = "transformables.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        if session.current() is None:
            cls.poll_message_set("No design is running")
            return False
        return True

    def execute(self, context):
        session.ask_to_end(session.current())
        return {"FINISHED"}


CLASSES = (TRANSFORMABLES_OT_cancel,)
