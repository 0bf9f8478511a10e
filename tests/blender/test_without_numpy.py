# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the python3 that comes first on PATH has no NumPy: the command starts Blender again, the window says it in words."""
import os
import subprocess
import sys

import bpy
import addon_utils
import pytest
import scenes
from transformables import cli
from transformables.bridge import system_python

HINT = "which has no NumPy"
FOLLOWS_PATH = bool(bpy.app.binary_path) and sys.prefix == "/usr"  # Debian's Blender; others bring a Python of their own


class Replaced(Exception):
    """In the place of execve, which doesn't come back."""


@pytest.fixture
def no_numpy(monkeypatch):
    monkeypatch.setitem(sys.modules, "numpy", None)  # import numpy raises ImportError


@pytest.fixture
def starts(monkeypatch):
    """Notes what would be started in our place; a headless Blender, the system's Python with NumPy."""
    calls = []

    def execve(*words):
        calls.append(words)
        raise Replaced

    monkeypatch.setattr(system_python.os, "execve", execve)
    monkeypatch.setattr(system_python, "_app", lambda: (True, "/opt/blender", "/no/such/folder"))
    monkeypatch.setattr(system_python, "_system_has_numpy", lambda: True)
    monkeypatch.delenv(system_python.STARTED_AGAIN, raising=False)
    return calls


def other_python(folder):
    """A prefix with this Python's own library and none of the system's packages. Gives its folder of programs."""
    version = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    (folder / "bin").mkdir()
    (folder / "lib" / version).mkdir(parents=True)
    for entry in os.scandir(os.path.dirname(os.__file__)):
        if entry.name != "dist-packages":
            (folder / "lib" / version / entry.name).symlink_to(entry.path)
    for name in ("python3", version):
        program = folder / "bin" / name
        program.write_text(f'#!/bin/sh\nexec /usr/bin/{version} "$@"\n')
        program.chmod(0o755)
    return folder / "bin"


def command(tmp_path, *words, **environment):
    """Runs the command on a small scene, in a Blender of its own whose first python3 has no NumPy."""
    scenes.armature([("body", None, (0, 0, 0), (0, 1, 0), 0, None), ("arm", "body", (0, 1, 0), (0, 2, 0), 0, scenes.X_ONLY)])
    scenes.cube()
    scene = tmp_path / "a scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    folder = tmp_path / "other"
    folder.mkdir()
    path = f"{other_python(folder)}:{os.environ['PATH']}"
    return subprocess.run([bpy.app.binary_path, "-b", str(scene), "--python", os.path.abspath(cli.__file__), "--", "design", *words],
                          capture_output=True, text=True, timeout=300, env={**os.environ, "PATH": path, **environment})


if FOLLOWS_PATH:
    def test_the_command_starts_blender_again_where_the_first_python3_has_no_numpy(empty_scene, tmp_path):
        done = command(tmp_path, "--resolution", "3", "--report", str(tmp_path / "r.json"))
        said = [line for line in done.stderr.splitlines() if line.startswith("transformables: ")]
        assert len(said) == 2 and "starting Blender again" in said[0] and "resolution is 3" in said[1]
        assert done.returncode == 2 and "Traceback" not in done.stderr

    def test_a_second_start_without_numpy_is_the_last(empty_scene, tmp_path):
        done = command(tmp_path, "--help", **{system_python.STARTED_AGAIN: "1"})
        assert done.returncode == 2 and HINT in done.stderr
        assert "again" not in done.stderr and "Traceback" not in done.stderr

    def test_enabling_the_addon_without_numpy_is_told_in_words(tmp_path):
        script = tmp_path / "enable.py"
        addon = os.path.dirname(os.path.dirname(os.path.abspath(cli.__file__)))
        script.write_text(f"import sys; sys.path.insert(0, {addon!r}); import addon_utils; "
                          "assert addon_utils.enable('transformables', default_set=True); print('ENABLED'); "
                          "addon_utils.disable('transformables', default_set=True); print('DISABLED')")
        path = f"{other_python(tmp_path)}:{os.environ['PATH']}"
        done = subprocess.run([bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "9", "--python", str(script)],
                              capture_output=True, text=True, timeout=120, env={**os.environ, "PATH": path})
        assert done.returncode == 0 and "ENABLED" in done.stdout and "DISABLED" in done.stdout
        assert HINT in done.stderr and "Traceback" not in done.stderr


def test_it_starts_the_same_words_with_the_systems_python_first(starts, no_numpy, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["blender", "-b", "a b.blend", "--", "design"])
    monkeypatch.setenv("PATH", "/other/bin:/usr/bin")
    with pytest.raises(Replaced):
        cli.main(["design"])
    (program, words, environment), = starts
    assert program == "/opt/blender" and words == ["blender", "-b", "a b.blend", "--", "design"]
    assert environment["PATH"] == "/usr/bin:/other/bin:/usr/bin" and environment[system_python.STARTED_AGAIN] == "1"


@pytest.mark.parametrize("reason", ["a window", "the second start", "the system has none either", "no program"])
def test_where_a_new_start_would_not_help_it_says_so_and_exits_2(starts, no_numpy, monkeypatch, capfd, reason):
    if reason == "a window":
        monkeypatch.setattr(system_python, "_app", lambda: (False, "/opt/blender", ""))
    if reason == "no program":
        monkeypatch.setattr(system_python, "_app", lambda: (True, "", ""))
    if reason == "the second start":
        monkeypatch.setenv(system_python.STARTED_AGAIN, "1")
    if reason == "the system has none either":
        monkeypatch.setattr(system_python, "_system_has_numpy", lambda: False)
    assert cli.main(["design", "--help"]) == 2
    assert starts == []
    lines = [line for line in capfd.readouterr().err.splitlines() if line.startswith("transformables: ")]
    assert len(lines) == 1 and HINT in lines[0]


def test_with_numpy_nothing_is_started(starts, capsys):
    assert cli.main(["design", "--help"]) == 0
    assert starts == []


def test_a_folder_that_is_only_called_numpy_is_none(tmp_path, monkeypatch):
    (tmp_path / "numpy").mkdir()
    assert not system_python.numpy_is_missing()
    for name in [n for n in sys.modules if n.split(".")[0] == "numpy"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert system_python.numpy_is_missing()


@pytest.mark.parametrize("answer", ["echo 3 6", "exit 1", None])
def test_a_system_python_that_is_absent_another_or_bare_does_not_help(tmp_path, monkeypatch, answer):
    if answer is not None:
        (tmp_path / "python3").write_text(f"#!/bin/sh\n{answer}\n")
        (tmp_path / "python3").chmod(0o755)
    monkeypatch.setattr(system_python, "SYSTEM_FOLDER", str(tmp_path))
    assert not system_python._system_has_numpy()
    (tmp_path / "python3").write_text(f"#!/bin/sh\necho {sys.version_info[0]} {sys.version_info[1]}\n")
    (tmp_path / "python3").chmod(0o755)
    assert system_python._system_has_numpy()


def test_the_panel_and_the_preferences_say_it_and_go_again(monkeypatch, capfd):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    monkeypatch.setattr(system_python, "numpy_is_missing", lambda: True)
    assert addon_utils.enable("transformables", default_set=True) is not None
    try:
        assert HINT in capfd.readouterr().err
        assert hasattr(bpy.types, "TRANSFORMABLES_PT_without_numpy") and not hasattr(bpy.types, "TRANSFORMABLES_PT_main")
        assert bpy.context.preferences.addons["transformables"].preferences is not None
    finally:
        addon_utils.disable("transformables", default_set=True)
    assert not hasattr(bpy.types, "TRANSFORMABLES_PT_without_numpy")
    monkeypatch.undo()
    assert addon_utils.enable("transformables", default_set=True) is not None
    assert hasattr(bpy.types, "TRANSFORMABLES_PT_main")
    addon_utils.disable("transformables", default_set=True)
