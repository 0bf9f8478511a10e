# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene for scenarios, and what they all do with it: open panels, start a design or a stage, look how far it is."""
import importlib
import os

import addon_utils
import bpy

import driver
from driver import click_button, open_tab, picture, wait_for

DESIGN = "bpy.ops.transformables.design"
STAND_IN = os.path.join(os.path.dirname(driver.HERE), "addon", "stand_in")  # a native module that behaves as its seed says
ANSWERS_SLOWLY, DEAF, KILLED = 1, 2, 3
LONGEST_DESIGN_SECONDS = 400  # drawing in software takes most of it


def make_scene():
    """A snake of four bones and an egg in an empty file, with the add-on enabled."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield 0.5
    enable()
    use_module_in(None)
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


def enable():
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
        use_module_in(STAND_IN)
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


def use_module_in(folder):
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


def run_stage(name):
    """Starts a stage's operator as its button does, and waits for its end."""
    with bpy.context.temp_override(window=driver.window(), area=driver.view()):
        assert getattr(bpy.ops.transformables, name)("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: running() is None, LONGEST_DESIGN_SECONDS, f"the end of {name}")
    assert not last_error(), last_error()
    yield 0.5


def with_open_panels(stage, *names_of_panels):
    """The scene, with these panels of a stage as of a user who has opened them."""
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
