# SPDX-License-Identifier: GPL-3.0-or-later
"""The one job that may run at a time, and what the last one had to say.

This is the only state outside the .blend. It holds names, numbers and text, never references to Blender's
data, so that undo, loading a file or deleting an object cannot leave it pointing at freed memory.
"""

import time
from dataclasses import dataclass, field

import bpy

STAGES = ("character", "target", "embedding", "segmentation", "folding", "finishing")
REDRAW_SECONDS = 0.2  # the panel need not follow every event of a fast stage


@dataclass
class Running:
    """A job under way: its worker, whom it is for, and how far it is."""

    job: object
    until: str
    scene: str
    character: str
    target: str
    timer: object = None
    window: object = None
    stage: str = ""
    fraction: float = 0.0
    note: str = ""
    cancel_wanted: bool = False
    stop_wanted: bool = False   # the best so far is wanted
    fingerprints: dict = field(default_factory=dict)  # of the inputs, by stage, when the job began
    from_guide: bool = False    # whether it goes on from the pose rig, which has then done its work
    gives_way: bool = False     # ends by itself when the artist begins something else
    warnings: list = field(default_factory=list)
    started: float = field(default_factory=time.monotonic)
    drawn: float = 0.0


@dataclass
class Last:
    """What stays in the panel until the next run."""

    error: str = ""
    warnings: list = field(default_factory=list)
    summary: str = ""


_current = None
last = Last()


def current():
    return _current


def begin(running):
    global _current
    if _current is not None:
        raise RuntimeError("a job is running already")
    _current = running
    forget()


def end():
    """Ends the running job, if there is one, and takes all its marks off the screen. Safe to call at any time."""
    global _current
    running, _current = _current, None
    if running is None:
        return
    try:
        running.job.cancel()
    finally:
        running.job.close()
        _clear_screen(running)


def ask_to_end(running):
    """Esc, or its button: a search for a pose ends with the best so far; all else, and at the second time, without a trace."""
    if running.until == "embedding" and running.stage == "embedding" and not running.stop_wanted:
        running.stop_wanted = True
        running.job.stop()
    else:
        running.cancel_wanted = True


def forget():
    last.error, last.warnings, last.summary = "", [], ""


def _clear_screen(running):
    manager = bpy.context.window_manager
    if running.timer is not None:
        manager.event_timer_remove(running.timer)
        manager.progress_end()
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)
    redraw()


def redraw():
    """Asks every 3D view, with its sidebar, to be drawn again."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def line():
    """The running job in one line, for the status bar and the panel."""
    running = _current
    if running is None:
        return ""
    stage = running.stage or "starting"
    place = f" ({STAGES.index(stage) + 1} of {len(STAGES)})" if stage in STAGES else ""
    note = f": {running.note}" if running.note and running.note != running.stage else ""
    return f"{stage.capitalize()}{place}{note}"
