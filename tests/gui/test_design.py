# SPDX-License-Identifier: GPL-3.0-or-later
"""Designs as a user makes, cancels and undoes them from the panel, and what goes wrong while one runs."""
import json
import os
import tempfile

import addon_utils
import bpy

import driver
from driver import click_button, find_button, open_tab, picture, press, wait_for
from scene import (ANSWERS_SLOWLY, DEAF, DESIGN, KILLED, LONGEST_DESIGN_SECONDS, STAND_IN, at_work, enable, last_error, make_scene, names, overlay_lines, roles,
                   run_stage, running, start_design, use_module_in, with_open_panels, worker_is_gone)

CANCEL = "bpy.ops.transformables.cancel"


def clicking_design_gives_the_result_and_ctrl_z_takes_it_away_in_one_step():
    pid = yield from start_design()
    before = names()
    yield from wait_for(lambda: running() is None or overlay_lines() > 0, 60, "a first pose")
    yield from picture("running")
    yield from wait_for(lambda: running() is None, LONGEST_DESIGN_SECONDS, "the result")
    assert not last_error(), last_error()
    made = roles()
    assert made.count("rig") == 1 and made.count("part") >= 2, made
    assert made.count("character") == 1 and made.count("target") == 1, made
    assert before < names()
    assert worker_is_gone(pid)
    assert bpy.context.scene.transformables.embedding_stage.stored
    yield from picture("result")
    yield from press("Z", ctrl=True)
    yield 1.0
    assert names() == before, names() ^ before
    assert roles() == [], roles()
    assert bpy.context.scene.transformables.embedding_stage.stored == ""
    assert not bpy.data.objects["Egg"].hide_get()


def esc_cancels_and_leaves_the_scene_as_it_was():
    pid = yield from start_design(DEAF)
    before = names()
    yield from at_work()
    yield from press("ESC")
    yield from wait_for(lambda: running() is None, 5, "Esc to end the design")
    yield 0.3
    assert worker_is_gone(pid)
    assert names() == before and roles() == []
    assert last_error() == ""
    yield from find_button(DESIGN)  # it can be started again


def the_cancel_button_in_the_panel_cancels():
    pid = yield from start_design(ANSWERS_SLOWLY)
    yield from at_work()
    yield from click_button(CANCEL)
    yield from wait_for(lambda: running() is None, 10, "the Cancel button to end the design")
    yield 0.5
    assert worker_is_gone(pid)


def disabling_the_add_on_ends_its_worker():
    pid = yield from start_design(ANSWERS_SLOWLY)
    yield from at_work()
    addon_utils.disable("transformables", default_set=True)
    yield 1.0
    assert worker_is_gone(pid)
    assert not hasattr(bpy.types.Scene, "transformables")
    yield from driver.move_to(*driver.middle_of_view())  # the operator's handler must be gone: events may not crash it
    yield 0.5
    enable()
    yield 0.5
    assert bpy.ops.transformables.design.poll()


def loading_a_file_ends_the_worker():
    path = os.path.join(tempfile.mkdtemp(), "other.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    pid = yield from start_design(ANSWERS_SLOWLY)
    yield from at_work()
    bpy.ops.wm.open_mainfile(filepath=path)
    yield 1.0
    assert running() is None
    assert worker_is_gone(pid)
    yield from driver.move_to(*driver.middle_of_view())
    yield 0.5
    assert "transformables" in bpy.context.preferences.addons


def deleting_the_target_while_it_runs_is_a_clear_error():
    pid = yield from start_design(ANSWERS_SLOWLY)
    yield from at_work()
    bpy.data.objects.remove(bpy.data.objects["Egg"])
    yield from wait_for(lambda: running() is None, 10, "the design to end")
    assert "Egg" in last_error() and "deleted" in last_error(), last_error()
    yield from picture("error")
    yield 0.5
    assert worker_is_gone(pid)
    assert roles() == []


def a_worker_that_dies_is_an_error_in_words_that_stays_in_the_panel():
    yield from start_design(KILLED)
    yield from wait_for(lambda: running() is None, 60, "the worker to die")
    assert "worker process ended" in last_error(), last_error()
    assert roles() == []
    yield 1.0
    assert "worker process ended" in last_error()
    yield from find_button(DESIGN)


def the_stages_run_one_by_one_each_from_the_stored_result():
    from transformables.ui.panel import StagePanel
    addon_utils.disable("transformables", default_set=True)
    StagePanel.bl_options = set()  # panels as of a user who has opened them all
    try:
        yield from make_scene()
    finally:
        StagePanel.bl_options = {"DEFAULT_CLOSED"}
    yield from open_tab(bpy.types.TRANSFORMABLES_PT_main)
    yield from picture("stages")
    settings = bpy.context.scene.transformables
    yield from run_stage("embed")
    pose = settings.embedding_stage.stored
    assert pose and roles() == []
    yield from picture("stage_embedding")
    yield from run_stage("segment")
    assert settings.embedding_stage.stored == pose and settings.segmentation_stage.stored
    yield from run_stage("plan_fold")
    assert settings.embedding_stage.stored == pose and settings.folding_stage.stored
    path = settings.folding_stage.stored
    yield from picture("stage_folding")
    yield from run_stage("finish")
    assert settings.embedding_stage.stored == pose and _turns(settings.folding_stage.stored) == _turns(path)
    assert roles().count("rig") == 1
    from transformables.ui import fingerprint
    assert fingerprint.fits(bpy.context.scene, "folding", settings.folding_stage.stored_for)
    settings.embedding_stage.seed = 7
    assert not fingerprint.fits(bpy.context.scene, "folding", settings.folding_stage.stored_for)
    yield from picture("stale")


def _turns(path):
    """All turns of a path in order; which of them go at the same time is finishing's choice."""
    return [turn for move in json.loads(path)["moves"] for turn in move]


def undo_while_it_runs_does_no_harm():
    yield from start_design(ANSWERS_SLOWLY)
    yield from at_work()
    with bpy.context.temp_override(window=driver.window()):
        bpy.ops.mesh.primitive_cube_add()
        bpy.context.object.name = "Extra"
        bpy.ops.ed.undo_push(message="Extra")
    yield from press("Z", ctrl=True)
    yield 0.5
    assert "Extra" not in names()
    assert running() is not None and roles() == []
    yield from wait_for(lambda: running() is None, LONGEST_DESIGN_SECONDS, "the result")
    assert not last_error(), last_error()
    assert "rig" in roles()


def a_pair_in_the_way_is_shown_at_its_moment_and_a_remedy_that_is_cancelled_changes_nothing():
    from transformables.ui import block_overlay
    yield from with_open_panels("folding", "TRANSFORMABLES_PT_folding", "TRANSFORMABLES_PT_blocks")
    use_module_in(STAND_IN)
    with bpy.context.temp_override(window=driver.window(), area=driver.view()):
        bpy.ops.transformables.design()
        bpy.ops.ed.undo_push(message="Design")
    settings = bpy.context.scene.transformables
    assert len(settings.folding_stage.blocks) == 1 and not block_overlay.shown()
    yield from open_tab(bpy.types.TRANSFORMABLES_PT_main)
    yield from driver.scroll_sidebar(30)
    before = bpy.context.scene.frame_current
    yield from click_button("bpy.ops.transformables.show_block", across=0.3)
    yield from wait_for(block_overlay.shown, 5, "the pair to be shown")
    assert bpy.context.scene.frame_current != before
    assert {o["transformable_bone"] for o in bpy.context.view_layer.objects if o.select_get()} == {"link0", "link1"}
    yield from picture("in_the_way")
    stored = settings.embedding_stage.stored
    yield from click_button("bpy.ops.transformables.keep_apart")
    yield from at_work()
    assert settings.embedding_stage.seed == ANSWERS_SLOWLY  # the next seed, by which the stand-in waits
    yield from press("ESC")
    yield from wait_for(lambda: running() is None, 10, "Esc to end the search")
    assert settings.embedding_stage.seed == 0 and not settings.embedding_stage.apart and settings.embedding_stage.stored == stored


SCENARIOS = (
    a_pair_in_the_way_is_shown_at_its_moment_and_a_remedy_that_is_cancelled_changes_nothing,
    clicking_design_gives_the_result_and_ctrl_z_takes_it_away_in_one_step,
    esc_cancels_and_leaves_the_scene_as_it_was,
    the_cancel_button_in_the_panel_cancels,
    disabling_the_add_on_ends_its_worker,
    loading_a_file_ends_the_worker,
    deleting_the_target_while_it_runs_is_a_clear_error,
    a_worker_that_dies_is_an_error_in_words_that_stays_in_the_panel,
    the_stages_run_one_by_one_each_from_the_stored_result,
    undo_while_it_runs_does_no_harm,
)
