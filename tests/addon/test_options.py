# SPDX-License-Identifier: GPL-3.0-or-later
import pytest
from transformables.core.options import DesignOptions, UserError


def test_the_defaults_are_those_of_the_contract_and_valid():
    options = DesignOptions()
    options.validate()
    assert (options.resolution, options.seed, options.symmetry, options.simplify, options.fit, options.proportions) == \
        (64, 0, "auto", "auto", "auto", True)
    assert (options.size_mm, options.clearance_mm, options.style) == (150, 0.3, "solid")


@pytest.mark.parametrize("change", [
    {"resolution": 4}, {"resolution": 2.5}, {"seed": -1}, {"symmetry": "maybe"}, {"simplify": "some"}, {"simplify": "1"},
    {"fit": "on"}, {"proportions": "on"}, {"size_mm": 0}, {"size_mm": float("nan")}, {"clearance_mm": -0.1},
    {"clearance_mm": 50.0}, {"style": "foam"}, {"transfer": "best"}, {"wall_mm": 0.0}, {"frames": 1}, {"frames": -3}, {"loop": "on"}, {"together": 1}, {"fold_seconds": 0.0}, {"threads": -1}])
def test_a_choice_that_cannot_be_used_is_refused_in_one_line(change):
    with pytest.raises(UserError) as caught:
        DesignOptions(**change).validate()
    assert "\n" not in str(caught.value) and len(str(caught.value)) > 10


def test_simplify_gives_the_largest_number_of_bones():
    assert [DesignOptions(simplify=s).bone_limit() for s in ("off", "auto", "18")] == [None, 25, 18]


def test_millimetres_and_target_units_are_each_others_inverse():
    options = DesignOptions(size_mm=200.0)
    assert options.target_units(200.0) == 0.5
    assert options.millimetres(options.target_units(0.3)) == pytest.approx(0.3)
