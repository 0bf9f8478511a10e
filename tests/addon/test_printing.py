# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts as files for printing."""
import importlib.util
import math
import pathlib
import re
import shutil
import struct
import warnings
import xml.etree.ElementTree
import zipfile

import pytest
from transformables.core import printing

ROOT = pathlib.Path(__file__).resolve().parents[2]
TETRAHEDRON = [(0.0, 0.0, 0.0), (20.0, 0.0, 0.0), (0.0, 30.0, 0.0), (0.0, 0.0, 40.0)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def read_stl(path):
    """[(normal, corners)] of a binary STL, read by its format's own description."""
    data = path.read_bytes()
    count, = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    rows = [struct.unpack_from("<12fH", data, 84 + 50 * n) for n in range(count)]
    return [(row[:3], [row[3 * k:3 * k + 3] for k in (1, 2, 3)]) for row in rows]


def test_an_stl_holds_every_triangle_with_its_outward_normal(tmp_path):
    printing.stl(tmp_path / "a.stl", "a", TETRAHEDRON, FACES)
    rows = read_stl(tmp_path / "a.stl")
    assert [corners for _, corners in rows] == [[TETRAHEDRON[c] for c in face] for face in FACES]
    for normal, corners in rows:
        assert math.hypot(*normal) == pytest.approx(1)
        assert sum(n * (c - 5.0) for n, c in zip(normal, corners[0])) > 0, "away from a point inside"
    assert not (tmp_path / "a.stl").read_bytes().startswith(b"solid"), "readers would take it for text"


def test_a_part_stands_on_the_plate_and_keeps_its_size_and_orientation():
    moved = printing.standing([(x - 7, y + 100, z - 3) for x, y, z in TETRAHEDRON])
    for axis in range(3):
        values = [p[axis] for p in moved]
        assert max(values) - min(values) == pytest.approx(max(p[axis] for p in TETRAHEDRON))
        assert min(values) == pytest.approx(0 if axis == 2 else -max(values))
    assert moved == [tuple(printing.single(x) for x in p) for p in moved], "what is written is what was looked at"


def test_triangles_that_single_precision_has_closed_are_left_out_and_the_rest_stays_joined():
    doubled = [*TETRAHEDRON, TETRAHEDRON[3]]
    faces = [(0, 2, 1), (0, 1, 3), (0, 4, 2), (1, 2, 4), (1, 4, 3), (3, 4, 0)]  # the apex is two points, with slivers between
    kept = printing.without_slivers(doubled, faces)
    assert sorted(map(sorted, kept)) == sorted(map(sorted, FACES))


def test_an_assembled_3mf_is_one_thing_whose_parts_stay_where_they_are(tmp_path):
    apart = [(x + 50, y, z) for x, y, z in TETRAHEDRON]
    printing.three_mf(tmp_path / "all.3mf", [("a", TETRAHEDRON, FACES), ("b", apart, FACES)], assembled=True)
    with zipfile.ZipFile(tmp_path / "all.3mf") as file:
        model = xml.etree.ElementTree.fromstring(file.read("3D/3dmodel.model"))
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    (item,) = model.iter(f"{core}item")
    assert "transform" not in item.attrib and item.get("objectid") == "3"
    assert [c.get("objectid") for c in model.iter(f"{core}component")] == ["1", "2"]
    placed = [[float(v.get(k)) for k in "xyz"] for v in model.iter(f"{core}vertex")]
    assert placed == [list(p) for p in [*TETRAHEDRON, *apart]]


def test_a_3mf_holds_all_parts_in_millimetres_side_by_side(tmp_path):
    parts = [(f"part <{n}>", TETRAHEDRON, FACES) for n in range(30)]
    printing.three_mf(tmp_path / "all.3mf", parts)
    with zipfile.ZipFile(tmp_path / "all.3mf") as file:
        assert {"[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"} == set(file.namelist())
        model = xml.etree.ElementTree.fromstring(file.read("3D/3dmodel.model"))
    name = {"m": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    assert model.get("unit") == "millimeter"
    objects = model.findall(".//m:object", name)
    assert [o.get("name") for o in objects] == [part[0] for part in parts]
    assert [tuple(float(v.get(a)) for a in "xyz") for v in objects[0].iterfind(".//m:vertex", name)] == TETRAHEDRON
    assert [tuple(int(t.get(a)) for a in ("v1", "v2", "v3")) for t in objects[0].iterfind(".//m:triangle", name)] == FACES
    places = [tuple(map(float, item.get("transform").split()[9:11])) for item in model.iterfind(".//m:item", name)]
    assert len(places) == 30
    for n, (x, y) in enumerate(places):
        assert all(abs(x - u) >= 20 + 1e-9 or abs(y - v) >= 30 + 1e-9 for u, v in places[:n])
    assert max(x for x, _ in places) <= printing.ROW_MM


def test_the_same_parts_give_the_same_file(tmp_path):
    for name in ("a", "b"):
        printing.three_mf(tmp_path / name, [("part", TETRAHEDRON, FACES)])
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_files_are_named_after_their_bones_and_no_two_alike():
    names = printing.file_names(["thigh.L", "Thigh.L", "arm/../../etc", "脚", "", "a b"], "stl")
    assert names[0] == "thigh.L.stl" and names[1] == "Thigh.L_2.stl"
    assert len({name.lower() for name in names}) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*\.stl", name) for name in names)


def test_the_print_check_passes_a_sound_part_and_no_broken_one(tmp_path):
    if not shutil.which("admesh") or not shutil.which("prusa-slicer"):
        warnings.warn("admesh or prusa-slicer is not installed: the print check was NOT tried", stacklevel=1)
        return
    spec = importlib.util.spec_from_file_location("print_check", ROOT / "scripts" / "print_check.py")
    print_check = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(print_check)
    apart = [(x + 100, y, z) for x, y, z in TETRAHEDRON]
    cases = {"sound": (TETRAHEDRON, FACES), "hole": (TETRAHEDRON, FACES[1:]), "flipped": (TETRAHEDRON, [FACES[0][::-1], *FACES[1:]]),
             "two": (TETRAHEDRON + apart, FACES + [tuple(c + 4 for c in face) for face in FACES]), "doubled": (TETRAHEDRON, FACES + FACES[:1])}
    for name, (vertices, faces) in cases.items():
        path = tmp_path / f"{name}.stl"
        printing.stl(path, name, vertices, faces)
        assert bool(print_check.admesh(path) + print_check.slicer(path)) == (name != "sound"), name
    assert print_check.sliced(tmp_path / "sound.stl", tmp_path) == []
