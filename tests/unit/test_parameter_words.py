"""What parameters of cases are called: no bare letter stands on an axis, and units are those of the cases."""

import pytest

from plumbline.harness.findings.parameter_words import axis_title, called, said
from plumbline.harness.study import plugins

CASES = plugins.cases()


def test_no_number_of_a_case_is_called_by_a_letter() -> None:
    numbers = {
        (name, parameter)
        for name, case in CASES.items()
        for parameter, value in case.parameters.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }
    assert {parameter for _, parameter in numbers} >= {"n", "speed", "worlds"}
    assert {(case, parameter) for case, parameter in numbers if len(called(case, parameter)) < 3} == set()


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.hard is not None])
def test_the_axis_of_a_case_has_the_unit_that_the_case_gives_it(name: str) -> None:
    hard = CASES[name].hard
    assert hard is not None
    assert axis_title(name, hard.parameter) == axis_title(name, hard.parameter, hard.unit)


def test_what_a_number_counts_depends_on_its_case() -> None:
    assert axis_title("stack_pile", "n") == "number of balls"
    assert axis_title("joint_chain", "n") == "number of links"
    assert axis_title("tunnel_sphere_wall", "speed") == "speed [m/s]"
    assert axis_title("spin_fast", "speed") == "spin [rad/s]"
    assert axis_title("scene:mine.toml", "grip_width") == "grip width"


def test_a_value_makes_a_phrase_with_what_it_is_of() -> None:
    assert said("stack_pile", "n", 100) == "100 balls"
    assert said("stack_pile", "n", 1.0) == "1 ball"
    assert said("tunnel_sphere_wall", "thickness", 0.02) == "wall thickness 0.02 m"
    assert said("tunnel_sphere_wall", "continuous", False) == "continuous off"
    assert said("system_rays", "thin", 64) == "one ray in 64"
    assert said("system_rays", "pattern", "lidar") == "lidar"
    assert said("scene:mine.toml", "grip_width", None) == "grip width None"
