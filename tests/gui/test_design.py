# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel as a user meets it, in a real window with simulated events. Run by scripts/gui_test.sh.

    blender --factory-startup --enable-event-simulate --python tests/gui/test_design.py -- [scenario ...]
"""
import os
import sys
import tempfile

import addon_utils
import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
for folder in (HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), "addon")):
    if folder not in sys.path:
        sys.path.insert(0, folder)

import driver  # noqa: E402  (its folder is put on the path just above)
from driver import click_button, find_button, open_tab, picture, press, wait_for  # noqa: E402

DESIGN = "bpy.ops.transformables.design"
CANCEL = "bpy.ops.transformables.cancel"
STAND_IN = os.path.join(os.path.dirname(HERE), "addon", "stand_in")  # a native module that behaves as its seed says
ANSWERS_SLOWLY, DEAF, KILLED = 1, 2, 3
LONGEST_DESIGN_SECONDS = 400  # drawing in software takes most of it


def make_scene():
    """A snake of four bones and an egg in an empty file, with the add-on enabled."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield 0.5
    _enable()
    _use_module_in(None)
    with bpy.context.temp_override(window=driver.window()):  # a timer has no window of its own
        _add_objects()
    yield 0.5


def _add_objects():
    armature = bpy.data.objects.new("Snake", bpy.data.armatures.new("Snake"))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for i in range(4):
        bone = armature.data.edit_bones.new(f"link{i}")
        bone.head, bone.tail = (0, i, 0), (0, i + 1, 0)
        bone.parent = parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, location=(4, 0, 0))
    bpy.context.object.name = "Egg"
    bpy.context.object.scale = (1.0, 1.4, 0.9)
    bpy.context.scene.transformables.target_stage.resolution = 32
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="Set-up")


def _enable():
    bpy.context.preferences.view.show_splash = False
    assert addon_utils.enable("transformables", default_set=True) is not None


def names():
    return {obj.name for obj in bpy.data.objects}


def roles():
    return sorted(obj["transformable_role"] for obj in bpy.data.objects if "transformable_role" in obj)


def running():
    from transformables.ui import session
    return session.current()


def worker_is_gone(pid):
    """Ended: no such process, or one that is only waiting to be collected."""
    try:
        with open(f"/proc/{pid}/stat") as f:
            return f.read().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def start_design(behaviour=None):
    """Opens the tab, clicks Design, and waits for the worker to be at work. Gives its process id.

    With a behaviour the worker runs the stand-in module, so that it is certainly still at work when something happens.
    """
    yield from make_scene()
    if behaviour is not None:
        _use_module_in(STAND_IN)
        bpy.context.scene.transformables.embedding_stage.seed = behaviour
    yield from open_tab(bpy.types.TRANSFORMABLES_PT_main)
    yield from picture("panel")
    yield from click_button(DESIGN)
    yield from wait_for(lambda: running() is not None or last_error(), 10, "the click to start a design")
    if behaviour == KILLED and not running():
        return None  # it was dead before anyone looked
    assert running() is not None, last_error()
    return running().job.pid


def at_work():
    """Waits until the worker is past its start: in the embedding, where the stand-in stays."""
    yield from wait_for(lambda: running() is None or running().stage == "embedding", 60, "the embedding stage")
    assert running() is not None, "the design ended before it could be looked at: " + last_error()


_real_native_dir = []


def _use_module_in(folder):
    """Lets workers load their native module from this folder; None: the real one."""
    from transformables.core import job
    if not _real_native_dir:
        _real_native_dir.append(job.native_dir)
    job.native_dir = (lambda: folder) if folder else _real_native_dir[0]


def overlay_lines():
    from transformables.ui import overlays
    return overlays.shown()


def last_error():
    from transformables.ui import session
    return session.last.error


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
    _enable()
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
    yield from _run_stage("embed")
    pose = settings.embedding_stage.stored
    assert pose and roles() == []
    yield from picture("stage_embedding")
    yield from _run_stage("segment")
    assert settings.embedding_stage.stored == pose and settings.segmentation_stage.stored
    yield from _run_stage("plan_fold")
    assert settings.embedding_stage.stored == pose and settings.folding_stage.stored
    path = settings.folding_stage.stored
    yield from picture("stage_folding")
    yield from _run_stage("finish")
    assert settings.embedding_stage.stored == pose and _turns(settings.folding_stage.stored) == _turns(path)
    assert roles().count("rig") == 1
    from transformables.ui import fingerprint
    assert fingerprint.fits(bpy.context.scene, "folding", settings.folding_stage.stored_for)
    settings.embedding_stage.seed = 7
    assert not fingerprint.fits(bpy.context.scene, "folding", settings.folding_stage.stored_for)
    yield from picture("stale")


def _turns(path):
    """All turns of a path in order; which of them go at the same time is finishing's choice."""
    import json
    return [turn for move in json.loads(path)["moves"] for turn in move]


def _run_stage(name):
    """Starts a stage's operator as its button does, and waits for its end."""
    with bpy.context.temp_override(window=driver.window(), area=driver.view()):
        assert getattr(bpy.ops.transformables, name)("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: running() is None, LONGEST_DESIGN_SECONDS, f"the end of {name}")
    assert not last_error(), last_error()
    yield 0.5


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


def _look_at_egg_from_above():
    from mathutils import Quaternion, Vector
    space = driver.view().spaces.active
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_rotation = Quaternion((1, 0, 0, 0))
    space.region_3d.view_location = Vector((4, 0, 0))
    space.region_3d.view_distance = 6
    yield 2.0


def _on_screen(point):
    """Where a point of the egg's own space is in the window."""
    from bpy_extras import view3d_utils
    from mathutils import Vector
    region = next(r for r in driver.view().regions if r.type == "WINDOW")
    place = view3d_utils.location_3d_to_region_2d(region, driver.view().spaces.active.region_3d, bpy.data.objects["Egg"].matrix_world @ Vector(point))
    return region.x + place.x, region.y + place.y


def _mouse(kind, value, x, y):
    driver.window().event_simulate(type=kind, value=value, x=int(x), y=int(y))
    yield driver.SETTLE


def _drag(x, y, by, key=None):
    """Presses, moves by some pixels with a turn of the wheel on the way, and releases or presses a key."""
    with bpy.context.temp_override(window=driver.window(), area=driver.view(), region=driver.sidebar()):
        assert bpy.ops.transformables.move_seam("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from driver.move_to(x, y)
    yield from _mouse("LEFTMOUSE", "PRESS", x, y)
    for step in range(1, 5):
        yield from driver.move_to(x, y + by * step / 4)
        if step in (2, 3):  # both make it larger, as in Blender's own proportional editing
            yield from _mouse("WHEELDOWNMOUSE" if step == 2 else "PAGE_UP", "PRESS", x, y + by * step / 4)
    yield from picture("drag")
    yield from _mouse(*(key, "PRESS") if key else ("LEFTMOUSE", "RELEASE"), x, y + by)
    yield 1.0


def _divide_and_look():
    """Divides the egg among the bones, with an undo step, and looks at it from above."""
    with bpy.context.temp_override(window=driver.window(), area=driver.view()):
        bpy.ops.transformables.embed()
        bpy.ops.transformables.segment()
        bpy.ops.ed.undo_push(message="Parts")
    yield from _look_at_egg_from_above()


def dragging_a_seam_keeps_it_where_it_is_released_and_esc_and_ctrl_z_take_it_back():
    yield from make_scene()
    bpy.context.scene.transformables.target_stage.resolution = 64
    yield from _divide_and_look()
    stage = bpy.context.scene.transformables.segmentation_stage
    import json
    before, seams = stage.seams, json.loads(stage.seams)
    top = max((p for s in seams if len(s["points"]) > 12 for p in s["points"]), key=lambda p: p[2])
    x, y = _on_screen(top)
    (times, sizes), parts = _timed(), _parts_on_surface()
    yield from _drag(x, y, 40, key="ESC")
    assert stage.seams == before and len(stage.edits) == 0
    assert (_parts_on_surface() == parts).all()
    yield from _drag(x, y, 40)
    stage = bpy.context.scene.transformables.segmentation_stage
    edit, = stage.edits
    assert edit.kind == "move_seam" and stage.seams != before
    places = [_on_screen(p) for s in json.loads(stage.seams) for p in s["points"]]
    assert min((px - x) ** 2 + (py - y - 40) ** 2 for px, py in places) < 8 ** 2, "the seam is where the mouse was released"
    assert (_parts_on_surface() != parts).sum() > 10, "places changed hands"
    print(f"a drag's updates take {1000 * max(times):.1f} ms at most ({len(times)} of them)", flush=True)
    assert max(times) < 0.033
    first = sizes[0]
    assert [round(size / first, 2) for size in dict.fromkeys(sizes)] == [1.0, 1.15, 1.32], "the wheel and the key let more of the seam follow"
    shares = stage.stored
    yield from wait_for(lambda: running() is None, 120, "the parts to settle")
    assert not last_error(), last_error()
    stage = bpy.context.scene.transformables.segmentation_stage
    assert stage.stored != shares, "the parts followed"
    places = [_on_screen(p) for s in json.loads(stage.seams) for p in s["points"]]
    assert min((px - x) ** 2 + (py - y - 40) ** 2 for px, py in places) < 12 ** 2, "the settled seam is where the mouse was released"
    yield from picture("released")
    yield from press("Z", ctrl=True)
    yield 1.0
    stage = bpy.context.scene.transformables.segmentation_stage
    assert stage.stored == shares and len(stage.edits) == 1, "the parts are as they were, the seam is still wished for"
    yield from press("Z", ctrl=True)
    yield 1.0
    stage = bpy.context.scene.transformables.segmentation_stage
    assert len(stage.edits) == 0 and stage.seams == before
    assert (_parts_on_surface() == parts).all()
    yield from press("Z", ctrl=True, shift=True)
    yield 1.0
    assert len(bpy.context.scene.transformables.segmentation_stage.edits) == 1


def a_seam_that_is_dragged_while_parts_settle_or_taken_back_ends_that_without_harm():
    import json
    yield from make_scene()
    yield from _divide_and_look()
    stage = bpy.context.scene.transformables.segmentation_stage
    shares = stage.stored
    from transformables.stages.segmentation import operators
    operators.TRANSFORMABLES_OT_settle_seams._take_events, real = (lambda self, context: None), operators.TRANSFORMABLES_OT_settle_seams._take_events
    for drags in (1, 2):
        seams = json.loads(bpy.context.scene.transformables.segmentation_stage.seams)
        top = max((p for s in seams if len(s["points"]) > 12 for p in s["points"]), key=lambda p: p[2])
        yield from _drag(*_on_screen(top), 25)
        assert running() is not None and len(bpy.context.scene.transformables.segmentation_stage.edits) == drags
    operators.TRANSFORMABLES_OT_settle_seams._take_events = real
    yield from press("Z", ctrl=True)
    yield from wait_for(lambda: running() is None, 60, "the job to end, as its wish is gone")
    stage = bpy.context.scene.transformables.segmentation_stage
    assert len(stage.edits) == 1 and stage.stored == shares
    assert not last_error(), last_error()


def _parts_on_surface():
    from transformables.bridge import division
    return division.read(bpy.context.scene.transformables.segmentation_stage.division)[2]


def _timed():
    """Seconds of computing of every update of a drag from now on, and the fall-off's size then: where the seam goes, which places follow, and their colours. Of this thread, as
    Blender's redraw and other programs do not count."""
    import time
    from transformables.stages.segmentation.seam_operator import TRANSFORMABLES_OT_move_seam as operator
    from transformables.ui import seam_overlay
    times, sizes, follow = [], [], operator._follow

    def timed(self, context, event):
        began = time.thread_time()
        follow(self, context, event)
        seam_overlay._dragged["surface"].batch(seam_overlay._dragged["parts"])
        times.append(time.thread_time() - began)
        sizes.append(self.size)
    operator._follow = timed
    return times, sizes


def exploring_lists_poses_and_clicking_one_draws_it_and_use_takes_it():
    yield from _with_open_panels("embedding", "TRANSFORMABLES_PT_embedding", "TRANSFORMABLES_PT_explore")
    _use_module_in(STAND_IN)
    group = bpy.context.scene.transformables.embedding_stage
    yield from open_tab(bpy.types.TRANSFORMABLES_PT_main)
    x, y = yield from find_button("bpy.ops.transformables.explore")
    yield from driver.click(x, y)
    yield from wait_for(lambda: running() is not None or len(group.solutions), 20, "the click to start exploring")
    yield from wait_for(lambda: running() is None, 60, "the poses")
    assert not last_error(), last_error()
    assert len(group.solutions) == 5 and group.solution == 0 and overlay_lines() == 4
    yield 1.0
    yield from driver.scroll_sidebar(20)
    yield from picture("explore")
    x, y = yield from find_button("bpy.ops.transformables.explore")
    from transformables.ui import overlays
    before = list(overlays._points)
    while group.solution == 0:  # down the list, row by row
        y -= 10
        assert y > driver.sidebar().y, "no row of the list could be clicked"
        yield from driver.click(x - 60, y)
    assert overlays._points != before, "the chosen pose is drawn"
    chosen = group.solutions[group.solution].embedding
    assert group.stored != chosen
    yield from click_button("bpy.ops.transformables.use_solution", across=0.3)
    yield from wait_for(lambda: group.stored == chosen, 5, "the pose to be used")
    yield from press("Z", ctrl=True)
    yield 1.0
    assert bpy.context.scene.transformables.embedding_stage.stored != chosen, "one step back undoes Use"


def a_pair_in_the_way_is_shown_at_its_moment_and_a_remedy_that_is_cancelled_changes_nothing():
    from transformables.ui import block_overlay
    yield from _with_open_panels("folding", "TRANSFORMABLES_PT_folding", "TRANSFORMABLES_PT_blocks")
    _use_module_in(STAND_IN)
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


def _with_open_panels(stage, *names_of_panels):
    """The scene, with these panels of a stage as of a user who has opened them."""
    import importlib
    panel = importlib.import_module(f"transformables.stages.{stage}.panel")
    addon_utils.disable("transformables", default_set=True)
    classes = [getattr(panel, name) for name in names_of_panels]
    closed = [cls.__dict__.get("bl_options") for cls in classes]
    for cls in classes:
        cls.bl_options = set()
    try:
        yield from make_scene()
    finally:
        for cls, options in zip(classes, closed):
            if options is None:
                del cls.bl_options
            else:
                cls.bl_options = options


SCENARIOS = (
    a_pair_in_the_way_is_shown_at_its_moment_and_a_remedy_that_is_cancelled_changes_nothing,
    exploring_lists_poses_and_clicking_one_draws_it_and_use_takes_it,
    clicking_design_gives_the_result_and_ctrl_z_takes_it_away_in_one_step,
    esc_cancels_and_leaves_the_scene_as_it_was,
    the_cancel_button_in_the_panel_cancels,
    disabling_the_add_on_ends_its_worker,
    loading_a_file_ends_the_worker,
    deleting_the_target_while_it_runs_is_a_clear_error,
    a_worker_that_dies_is_an_error_in_words_that_stays_in_the_panel,
    the_stages_run_one_by_one_each_from_the_stored_result,
    undo_while_it_runs_does_no_harm,
    dragging_a_seam_keeps_it_where_it_is_released_and_esc_and_ctrl_z_take_it_back,
    a_seam_that_is_dragged_while_parts_settle_or_taken_back_ends_that_without_harm,
)


def chosen():
    wanted = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    unknown = [name for name in wanted if name not in {s.__name__ for s in SCENARIOS}]
    if unknown:
        print(f"no such scenario: {', '.join(unknown)}; there are: {', '.join(s.__name__ for s in SCENARIOS)}", flush=True)
        os._exit(2)
    return [s for s in SCENARIOS if not wanted or s.__name__ in wanted]


driver.run(chosen())
