# SPDX-License-Identifier: GPL-3.0-or-later
"""A search for folded poses: its list, and what an artist sees and does while it runs."""
import bpy

import driver
from driver import click_button, find_button, open_tab, picture, press, wait_for
from scene import STAND_IN, last_error, overlay_lines, running, use_module_in, with_open_panels


def exploring_lists_poses_and_clicking_one_draws_it_and_use_takes_it():
    yield from with_open_panels("embedding", "TRANSFORMABLES_PT_embedding", "TRANSFORMABLES_PT_explore")
    use_module_in(STAND_IN)
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


SCENARIOS = (
    exploring_lists_poses_and_clicking_one_draws_it_and_use_takes_it,
)
