# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts in files for printing, of a result made by hand."""
import bpy
import numpy as np
import pytest
from hand_made import BOX, BOX_FACES, hand_made, made, scene  # scene and made are fixtures
from transformables.bridge import design, printing
from transformables.core.options import DesignOptions, UserError


@pytest.mark.parametrize("file_format", ["stl", "3mf", "assembled"])
def test_parts_are_exported_in_millimetres_at_the_designs_size(scene, tmp_path, file_format):
    options = DesignOptions(size_mm=80.0)
    made = design.apply(bpy.context, *hand_made(*scene, options), *scene, options)
    names = printing.export(made["rig"], str(tmp_path / "new" / "folder"), file_format)
    assert sorted(p.name for p in (tmp_path / "new" / "folder").iterdir()) == sorted(names), "nothing but the parts"
    assert len(names) == (len(made["parts"]) if file_format == "stl" else 1)
    for name, points, triangles in printing.parts_of(made["rig"]):
        size = np.ptp(np.array(points), axis=0)
        assert size == pytest.approx(np.ptp(BOX, axis=0) * 80.0 / 0.5, rel=1e-5), name  # 0.5 target units are as long as the size
        assert len(triangles) == len(BOX_FACES)


def test_assembled_parts_stand_to_each_other_as_the_scene_shows_them(scene, made):
    rig, scale = made["rig"], made["rig"][printing.MM]
    for frame in (bpy.context.scene.frame_start, bpy.context.scene.frame_end):
        bpy.context.scene.frame_set(frame)
        shown = {o["transformable_bone"]: np.array([rig.matrix_world.inverted() @ o.matrix_world @ v.co for v in o.data.vertices]) for o in made["parts"]}
        exported = {name: np.array(points) for name, points, _ in printing.parts_of(rig, assembled=True)}
        shift = next(exported[name][0] - shown[name][0] * scale for name in exported)
        for name, points in exported.items():
            assert np.abs(points - shown[name] * scale - shift).max() < 1e-3, name
        assert min(points[:, 2].min() for points in exported.values()) == pytest.approx(0, abs=1e-4), "on the plate"


def test_a_design_without_its_size_or_a_folder_that_cannot_be_written_is_refused_in_words(made, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="choose a folder"):
        printing.export(made["rig"], str(tmp_path / "file" / "below"))
    del made["rig"][printing.MM]
    with pytest.raises(UserError, match="older version"):
        printing.export(made["rig"], str(tmp_path))
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
