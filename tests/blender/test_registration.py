# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on registers and unregisters cleanly, in Blender 3.4.1 and in a current bpy.

Runs inside Blender (pytest.main) or with PyPI's bpy in a plain Python.
"""
import io
import os
import re
import subprocess
import sys
import warnings
from contextlib import redirect_stderr, redirect_stdout

import bpy  # first: it makes addon_utils findable
import addon_utils
import pytest

ADDON = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "addon")
OPERATORS = ("design", "cancel", "check_character", "check_target", "embed", "segment", "plan_fold", "finish", "hide_pose",
             "explore", "continue_pose", "pose_guide", "list_bones", "use_solution", "delete_solution",
             "add_edit", "remove_edit", "move_seam", "add_preset")
PANELS = ("main", "character", "target", "embedding", "segmentation", "folding", "finishing")

if ADDON not in sys.path:
    sys.path.insert(0, ADDON)


@pytest.fixture
def enabled():
    bpy.ops.wm.read_factory_settings(use_empty=True)  # before: it would disable the add-on
    module = addon_utils.enable("transformables", default_set=True)
    assert module is not None
    yield module
    addon_utils.disable("transformables", default_set=True)


def _our_types():
    kinds = (bpy.types.Operator, bpy.types.Panel, bpy.types.PropertyGroup, bpy.types.AddonPreferences)
    return sorted(cls.__name__ for kind in kinds for cls in kind.__subclasses__() if cls.is_registered
                  and cls.__module__.startswith("transformables"))


def _make_scene():
    armature = bpy.data.objects.new("Walker", bpy.data.armatures.new("Walker"))
    mesh = bpy.data.meshes.new("Block")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    block = bpy.data.objects.new("Block", mesh)
    for obj in (armature, block):
        bpy.context.scene.collection.objects.link(obj)
    return armature, block


def test_registers_and_unregisters_three_times_without_a_warning():
    said = io.StringIO()
    with warnings.catch_warnings(), redirect_stdout(said), redirect_stderr(said):
        warnings.simplefilter("error")
        for _ in range(3):
            assert addon_utils.enable("transformables", default_set=True) is not None
            addon_utils.disable("transformables", default_set=True)
    assert said.getvalue() == ""


def test_a_fresh_program_registers_it_without_a_word(tmp_path):
    """Blender's own complaints (bad names, missing texts) go past Python's streams: only another process shows them."""
    body = (f"import sys; sys.path.insert(0, {ADDON!r}); import bpy, addon_utils; "
            "assert addon_utils.enable('transformables', default_set=True); print('ENABLED'); "
            "addon_utils.disable('transformables', default_set=True); print('DISABLED')")
    script = tmp_path / "enable.py"
    script.write_text(body)
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "9", "--python", str(script)]
    else:
        command = [sys.executable, "-W", "error", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "ENABLED" in said and "DISABLED" in said
    assert not re.search(r"warn|error|traceback|should|contain|rna_", said, re.IGNORECASE), said


def test_everything_that_was_registered_is_gone_afterwards(enabled):
    assert len(_our_types()) >= len(OPERATORS) + len(PANELS)
    addon_utils.disable("transformables", default_set=True)
    try:
        assert _our_types() == []
        assert not hasattr(bpy.types.Scene, "transformables")
        assert not hasattr(bpy.types.WindowManager, "transformables_progress")
        for handlers in (bpy.app.handlers.load_pre, bpy.app.handlers.undo_post):
            assert not any(f.__module__.startswith("transformables") for f in handlers)
    finally:
        addon_utils.enable("transformables", default_set=True)


def test_every_operator_and_setting_has_a_tooltip(enabled):
    for name in OPERATORS:
        rna = getattr(bpy.ops.transformables, name).get_rna_type()
        assert len(rna.description) > 15, name
        assert not rna.description.endswith("."), f"{name}: Blender adds the full stop"
    settings = bpy.context.scene.transformables
    stages = [getattr(settings, f"{stage}_stage") for stage in PANELS[1:]]
    for group in (settings, *stages):
        for prop in group.bl_rna.properties:
            if prop.identifier not in ("rna_type", "name") and prop.type != "POINTER" and not prop.is_hidden:
                assert len(prop.description) > 15, f"{group}: {prop.identifier}"


def test_slow_operators_are_one_undo_step_and_never_run_again_by_the_redo_panel(enabled):
    for name in ("design", "embed", "segment", "plan_fold", "finish", "move_seam"):
        assert getattr(bpy.types, f"TRANSFORMABLES_OT_{name}").bl_options == {"UNDO"}


def test_preferences_are_there_and_a_script_without_them_gets_the_same_defaults(enabled):
    from transformables.ui import preferences
    own = preferences.get()
    assert own is not preferences.Defaults
    for name in ("threads", "show_pose", "pose_width"):
        assert getattr(own, name) == getattr(preferences.Defaults, name)
    addon_utils.disable("transformables", default_set=True)
    assert preferences.get() is preferences.Defaults
    addon_utils.enable("transformables", default_set=True)


def test_panels_sit_in_the_sidebar_tab(enabled):
    for name in PANELS:
        panel = getattr(bpy.types, f"TRANSFORMABLES_PT_{name}")
        assert (panel.bl_category, panel.bl_space_type, panel.bl_region_type) == ("Transformables", "VIEW_3D", "UI")


def test_the_only_armature_and_the_only_mesh_are_taken(enabled):
    from transformables.ui import settings
    armature, block = _make_scene()
    scene = bpy.context.scene
    assert settings.picked(scene, "character") == armature
    assert settings.picked(scene, "target") == block
    assert bpy.ops.transformables.design.poll()


def test_with_two_meshes_the_user_has_to_pick(enabled):
    from transformables.ui import settings
    _, block = _make_scene()
    scene = bpy.context.scene
    other = bpy.data.objects.new("Other", block.data.copy())
    scene.collection.objects.link(other)
    assert settings.picked(scene, "target") is None
    assert not bpy.ops.transformables.design.poll()
    scene.transformables.target = other
    assert settings.picked(scene, "target") == other


def test_an_object_that_left_the_scene_is_not_used(enabled):
    from transformables.ui import settings
    _, block = _make_scene()
    scene = bpy.context.scene
    scene.transformables.target = block
    scene.collection.objects.unlink(block)
    assert settings.picked(scene, "target") is None
    assert "target" in settings.missing(scene)


def test_rigs_and_parts_of_an_earlier_design_are_not_offered(enabled):
    from transformables.ui import settings
    armature, block = _make_scene()
    scene = bpy.context.scene
    rig, part = armature.copy(), block.copy()
    rig["transformable_role"], part["transformable_role"] = "rig", "part"
    for obj in (rig, part):
        scene.collection.objects.link(obj)
    assert settings.picked(scene, "character") == armature
    assert settings.picked(scene, "target") == block


def test_a_stored_result_goes_out_of_date_when_its_inputs_change(enabled):
    from transformables.ui import fingerprint
    _, block = _make_scene()
    scene = bpy.context.scene
    kept = fingerprint.take(scene, "embedding")
    assert fingerprint.fits(scene, "embedding", kept) and fingerprint.fits(scene, "embedding", kept, thorough=True)
    scene.transformables.finishing_stage.clearance_mm = 0.7
    assert fingerprint.fits(scene, "embedding", kept)
    scene.transformables.embedding_stage.seed = 5
    assert not fingerprint.fits(scene, "embedding", kept)
    scene.transformables.embedding_stage.seed = 0
    assert fingerprint.fits(scene, "embedding", kept)
    block.data.vertices[1].co.x = 0.5
    block.data.update()
    bpy.context.view_layer.update()
    assert not fingerprint.fits(scene, "embedding", kept, thorough=True)


def test_moving_the_target_or_scaling_it_evenly_keeps_the_stored_pose(enabled):
    from transformables.ui import fingerprint
    _, block = _make_scene()
    scene = bpy.context.scene
    kept = fingerprint.take(scene, "embedding")
    block.location, block.scale = (3, 4, 5), (2, 2, 2)
    bpy.context.view_layer.update()
    assert fingerprint.fits(scene, "embedding", kept, thorough=True)
    block.scale = (2, 1, 1)
    bpy.context.view_layer.update()
    assert not fingerprint.fits(scene, "embedding", kept)


def test_settings_become_options_that_hold(enabled):
    from transformables.ui.job_operator import options_of
    _make_scene()
    s = bpy.context.scene.transformables
    s.character_stage.simplify, s.character_stage.simplify_count = "count", 12
    s.embedding_stage.proportions = False
    options = options_of(bpy.context.scene)
    assert (options.simplify, options.proportions, options.resolution, options.size_mm) == ("12", False, 64, 150.0)


def test_defaults_of_the_panel_are_those_of_the_command(enabled):
    from transformables.core.options import DesignOptions
    from transformables.ui.job_operator import options_of
    _make_scene()
    options = options_of(bpy.context.scene)
    fresh = DesignOptions()
    assert {k: round(v, 4) if isinstance(v, float) else v for k, v in options.as_dict().items()} == fresh.as_dict()


def test_checking_a_target_tells_of_its_holes(enabled):
    _, block = _make_scene()
    assert bpy.ops.transformables.check_target() == {"FINISHED"}
    group = bpy.context.scene.transformables.target_stage
    assert "Closed" in group.stored
    block.data.clear_geometry()
    block.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    assert bpy.ops.transformables.check_target() == {"FINISHED"}
    assert "3 open edges" in group.stored


def test_a_target_without_faces_is_refused_in_words(enabled):
    _, block = _make_scene()
    block.data.clear_geometry()
    with pytest.raises(RuntimeError, match="has no faces"):
        bpy.ops.transformables.check_target()


def test_the_command_is_there_where_blender_has_commands(enabled):
    import transformables
    has_commands = hasattr(bpy.utils, "register_cli_command")  # 4.2 brought them
    assert len(transformables._command) == (1 if has_commands else 0)


if __name__ == "__main__":
    sys.stdout.flush()
    code = pytest.main(["-q", "-p", "no:cacheprovider", os.path.abspath(__file__)])
    sys.stdout.flush()
    os._exit(int(code))
