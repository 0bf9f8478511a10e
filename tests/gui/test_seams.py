# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams that are dragged on the target."""
import json
import time

import bpy

import driver
from driver import picture, press, wait_for
from scene import last_error, make_scene, running


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


SCENARIOS = (
    dragging_a_seam_keeps_it_where_it_is_released_and_esc_and_ctrl_z_take_it_back,
    a_seam_that_is_dragged_while_parts_settle_or_taken_back_ends_that_without_harm,
)
