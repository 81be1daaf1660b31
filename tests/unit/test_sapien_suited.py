"""Which solver of PhysX, iterations, bound and gap a scene is given on 'tuned'; nothing of SAPIEN is asked."""

from dataclasses import replace

import pytest

from plumbline.adapters.sapien import ADAPTER
from plumbline.adapters.sapien.options import UNBOUNDED, resolved_settings
from plumbline.adapters.sapien.suited import PARTING, TOUCH
from plumbline.harness.adapter.reduced_trees import trees_of
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
        ("impact_bounce", False, "tgs"),  # rebounds until it rests
        ("impact_pairs", False, "pgs"),  # rebounds where nothing presses
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


@pytest.mark.parametrize(
    ("case", "iterations"), [("stand_humanoid", 255), ("stand_quadruped", 50), ("stand_hit", 50), ("stack_pyramid", 50)]
)
def test_a_machine_on_feet_that_are_light_beside_it_is_given_the_most_iterations(case: str, iterations: int) -> None:
    scene = plugins.case(case).scene(plugins.case(case).at())
    assert resolved_settings(TUNED, scene, False, trees_of(scene, scene.joints)).iterations == iterations
    assert resolved_settings(ADAPTER.tracks["default"], scene, False, trees_of(scene, scene.joints)).iterations == 10
    assert resolved_settings(replace(TUNED, iterations=25), scene, False, trees_of(scene, scene.joints)).iterations == 25


@pytest.mark.parametrize(("case", "gap"), [("impact_oblique", TOUCH), ("impact_bounce", 0.01), ("impact_momentum", 0.01)])
def test_contacts_begin_at_a_touch_where_things_rebound_without_gravity(case: str, gap: float) -> None:
    scene = plugins.case(case).scene(plugins.case(case).at())
    assert resolved_settings(TUNED, scene, False).options["contact_offset"] == gap


def test_a_solver_and_a_bound_that_are_told_stay() -> None:
    scene = plugins.case("stack_overlap_recovery").scene(plugins.case("stack_overlap_recovery").at())
    assert resolved_settings(replace(TUNED, solver="tgs"), scene, False).options["max_depenetration_velocity"] == UNBOUNDED
    freed = replace(TUNED, options={**TUNED.options, "max_depenetration_velocity": 1.0})
    assert resolved_settings(freed, scene, False).options["max_depenetration_velocity"] == 1.0
    assert resolved_settings(ADAPTER.tracks["default"], scene, False).solver == "tgs"
