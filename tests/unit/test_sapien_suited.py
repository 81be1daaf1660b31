"""Which solver of PhysX a scene is given on 'tuned', and the bound that goes with it; nothing of SAPIEN is asked."""

from dataclasses import replace

import pytest

from plumbline.adapters.sapien import ADAPTER
from plumbline.adapters.sapien.options import UNBOUNDED, resolved_settings
from plumbline.adapters.sapien.suited import PARTING
from plumbline.harness.study import plugins

TUNED = ADAPTER.tracks["tuned"]


@pytest.mark.parametrize(
    ("case", "constrained", "solver"),
    [
        ("joint_conical_pendulum", True, "tgs"),  # a ball joint
        ("joint_fourbar", True, "tgs"),  # a loop
        ("joint_spring", False, "tgs"),  # a tree with springs
        ("joint_chain", False, "pgs"),  # a tree without
        ("stand_quadruped", False, "pgs"),  # drives that hold what stands
        ("impact_pairs", False, "tgs"),  # rebounds
        ("impact_momentum", False, "pgs"),  # blows that nothing presses
        ("friction_turntable", False, "tgs"),  # led
        ("friction_spinning", False, "tgs"),  # turns on its feet
        ("friction_isotropy", False, "pgs"),  # slides
        ("stack_mass_ratio", False, "tgs"),  # 1:1000
        ("stack_overlap_recovery", False, "pgs"),
        ("spin_principal", False, "pgs"),
    ],
)
def test_a_scene_is_given_the_solver_that_suits_it(case: str, constrained: bool, solver: str) -> None:
    scene = plugins.case(case).scene(plugins.case(case).at())
    used = resolved_settings(TUNED, scene, constrained)
    assert (used.solver, used.options["max_depenetration_velocity"]) == (solver, PARTING if solver == "pgs" else UNBOUNDED)


def test_a_solver_and_a_bound_that_are_told_stay() -> None:
    scene = plugins.case("stack_overlap_recovery").scene(plugins.case("stack_overlap_recovery").at())
    assert resolved_settings(replace(TUNED, solver="tgs"), scene, False).options["max_depenetration_velocity"] == UNBOUNDED
    freed = replace(TUNED, options={**TUNED.options, "max_depenetration_velocity": 1.0})
    assert resolved_settings(freed, scene, False).options["max_depenetration_velocity"] == 1.0
    assert resolved_settings(ADAPTER.tracks["default"], scene, False).solver == "tgs"
