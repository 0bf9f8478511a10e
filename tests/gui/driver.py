# SPDX-License-Identifier: GPL-3.0-or-later
"""A user at the window: moves the mouse, clicks, presses keys, looks what is under the pointer, and waits.

A scenario is a generator that yields after each thing done, so that Blender handles events and draws in between:
a number yielded is a time to wait, in seconds. Blender has to be started with --enable-event-simulate.
"""
import os
import sys
import time
import traceback

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
SETTLE = 0.1  # seconds after an event; drawing in software takes the longer part by itself


def window():
    return bpy.context.window_manager.windows[0]


def view():
    """The largest 3D view of the window."""
    return max((a for a in window().screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width * a.height)


def sidebar():
    return next(r for r in view().regions if r.type == "UI")


def move_to(x, y):
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))
    yield SETTLE


def click(x, y):
    yield from move_to(x, y)
    window().event_simulate(type="LEFTMOUSE", value="PRESS", x=int(x), y=int(y))
    yield SETTLE
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=int(x), y=int(y))
    yield SETTLE


def middle_of_view():
    region = next(r for r in view().regions if r.type == "WINDOW")
    return region.x + region.width // 3, region.y + region.height // 2


def press(key, **modifiers):
    x, y = middle_of_view()
    yield from move_to(x, y)
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=x, y=y, **modifiers)
        yield SETTLE


def button_under_mouse():
    """The Python call of the operator button under the pointer, as 'Copy Python Command' gives it; empty when there is none."""
    manager = bpy.context.window_manager
    manager.clipboard = "-"
    with bpy.context.temp_override(window=window(), area=view(), region=sidebar()):
        if not bpy.ops.ui.copy_python_command_button.poll():
            return ""
        bpy.ops.ui.copy_python_command_button()
    return "" if manager.clipboard == "-" else manager.clipboard


def find_button(call, across=0.5):
    """Moves the pointer down the sidebar until it is over the button for this call. Gives its place. `across`: of the sidebar's width."""
    region = sidebar()
    x = region.x + int(region.width * across) - 10
    for y in range(region.y + region.height - 20, region.y + 5, -9):
        yield from move_to(x, y)
        if button_under_mouse().startswith(call):
            return x, y
    raise AssertionError(f"no button for {call} is to be seen in the sidebar")


def click_button(call, across=0.5):
    x, y = yield from find_button(call, across)
    yield from click(x, y)


def scroll_sidebar(turns):
    """Turns the wheel over the sidebar, downwards."""
    region = sidebar()
    x, y = region.x + region.width // 2, region.y + region.height // 2
    yield from move_to(x, y)
    for _ in range(turns):
        window().event_simulate(type="WHEELDOWNMOUSE", value="PRESS", x=x, y=y)
        yield SETTLE
    yield 1.0  # it scrolls smoothly


def open_tab(panel):
    """Shows the sidebar and clicks on its tabs, from the lowest up, until this panel is drawn."""
    drawn = []

    def note(*_):
        drawn.append(time.monotonic())

    view().spaces.active.show_region_ui = True
    yield 1.0
    panel.append(note)
    try:
        region = sidebar()
        for y in range(region.y + region.height - 20, region.y + 5, -40):
            yield from click(region.x + region.width - 12, y)
            yield 0.3
            if drawn:
                return
    finally:
        panel.remove(note)
    raise AssertionError("the sidebar has no tab that shows the panel")


def wait_for(condition, seconds, what):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited {seconds} s for {what}")
        yield 0.05


def picture(name):
    """A screenshot, when a folder for them is given; the pointer may stand anywhere."""
    folder = os.environ.get("TRANSFORMABLES_SCREENSHOTS")
    if folder:
        yield 2.0
        with bpy.context.temp_override(window=window(), area=view()):
            bpy.ops.screen.screenshot(filepath=os.path.join(folder, f"{name}.png"))
        yield SETTLE


def run(scenarios):
    """Plays scenarios one after another, tells how each went, and quits with 0 when all went well."""
    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(_player(scenarios), first_interval=1.0, persistent=True)


def _player(scenarios):
    waiting, failed = list(scenarios), []
    now = []

    def tick():
        try:
            if not now:
                if not waiting:
                    _quit(failed)
                    return None
                now.append((waiting[0].__name__, waiting.pop(0)(), time.monotonic()))
            return next(now[0][1]) or 0.0
        except StopIteration:
            name, _, began = now.pop()
            print(f"PASS {name} ({time.monotonic() - began:.0f} s)", flush=True)
        except Exception:  # told and counted: the next scenario shall run all the same
            name = now.pop()[0]
            failed.append(name)
            print(f"FAIL {name}\n{traceback.format_exc()}", flush=True)
        return 0.1

    return tick


def _quit(failed):
    print("FAILED: " + ", ".join(failed) if failed else "ALL PASSED", flush=True)
    sys.stdout.flush()
    os._exit(1 if failed else 0)
