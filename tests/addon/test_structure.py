"""The rules of the house: which room may include which, and who may know Blender or Python."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOMS = ["common", "character", "target", "embedding", "segmentation", "folding", "finishing"]
INCLUDE = re.compile(r'^\s*#include "([^"]+)"', re.M)


def sources(folder):
    return [p for p in folder.rglob("*") if p.suffix in {".h", ".cpp"}]


def wrong_includes(path, room):
    for name in INCLUDE.findall(path.read_text()):
        other = name.split("/")[0]
        if other in (room, "common"):
            continue
        earlier = other in ROOMS[: ROOMS.index(room)]
        if not (earlier and name == f"{other}/{other}.h"):
            yield name


def test_a_room_includes_only_its_own_files_common_and_the_doors_of_rooms_before_it():
    wrong = {str(p): list(wrong_includes(p, room)) for room in ROOMS for p in sources(ROOT / "native" / room)}
    assert not {p: names for p, names in wrong.items() if names}


def test_nothing_native_but_the_bindings_knows_python():
    knowing = [p for room in ROOMS for p in sources(ROOT / "native" / room) if re.search(r"pybind11|Python\.h", p.read_text())]
    assert not knowing


def test_only_bridge_stages_ui_and_the_entry_points_import_bpy():
    addon = ROOT / "addon" / "transformables"
    allowed = {"bridge", "stages", "ui", "__init__.py", "cli.py"}
    knowing = [p for p in addon.rglob("*.py") if re.search(r"^\s*(import|from) (bpy|mathutils)", p.read_text(), re.M)
               and p.relative_to(addon).parts[0] not in allowed]
    assert not knowing


def test_each_room_has_a_door_and_a_native_test():
    for room in ROOMS[1:]:
        assert (ROOT / "native" / room / f"{room}.h").exists()
        tests = ROOT / "tests" / "native"  # one file, or a folder of the room's name with one file a source
        assert (tests / f"test_{room}.cpp").exists() or list((tests / room).glob("test_*.cpp"))


def test_no_folder_is_empty():
    folders = [p for top in ("native", "addon", "tests", "docs", "scripts", "blend_examples") for p in (ROOT / top).rglob("*") if p.is_dir()]
    assert not [p for p in folders if p.name != "__pycache__" and not any(p.iterdir())]
