"""What MuJoCo's tuned track chooses by the scene: matrices, where shapes stand, and how firm contacts are."""

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from plumbline.adapters.mujoco.pressed_through import give
from plumbline.adapters.mujoco.simulation import MujocoSimulation
from plumbline.harness.case import Case
from plumbline.harness.scene import Scene, Sphere
from tests.conformance.mujoco_scenes import DEFAULT, TUNED, G, built, hinge_at, on_ground, shaped_body, state_of


def scene_of(case: str, **parameters: Any) -> Scene:
    told: Case = importlib.import_module(f"plumbline.cases.{case}").CASE
    return told.scene(told.at(**parameters))


def model_of(simulation: MujocoSimulation) -> Any:
    return simulation._world.model


@pytest.mark.parametrize(
    ("case", "parameters", "chosen"),
    [
        # No constraint at all; free bodies, in threes; hinges whose feet touch the ground alone; loops of hinges.
        ("system_scaling", {"kind": "flight", "n": 64}, "auto"),
        ("system_scaling", {"kind": "chain", "n": 64}, "auto"),
        ("system_scaling", {"kind": "contact", "n": 64}, "auto"),
        ("stack_pile", {"n": 30}, "auto"),
        ("stand_quadruped", {"n": 4}, "auto"),
        ("joint_fourbar", {}, "dense"),
    ],
)
def test_dense_matrices_stand_in_for_the_sparse_factor_where_that_can_be_wrong(
    case: str, parameters: dict[str, Any], chosen: str
) -> None:
    scene = scene_of(case, **parameters)
    simulation = built(scene, TUNED)
    assert simulation.resolved.options["jacobian"] == chosen
    for warned in (simulation, built(scene, DEFAULT)):
        assert not [notice for notice in warned.warnings() if "sparse factor" in notice.text]


def test_hinged_bodies_that_can_touch_each_other_get_dense_matrices_on_tuned_and_a_notice_on_default() -> None:
    balls = [shaped_body(f"ball_{k}", Sphere(radius=0.1), (k, 0.0, 0.0)) for k in range(60)]
    hinges = tuple(hinge_at(f"hinge_{k}", "world", ball.name, (k, 0.0, 1.0)) for k, ball in enumerate(balls))
    scene = replace(on_ground(*balls), joints=hinges)
    assert built(scene, TUNED).resolved.options["jacobian"] == "dense"
    assert [notice for notice in built(scene, DEFAULT).warnings() if "sparse factor" in notice.text]


@pytest.mark.parametrize("settings", [DEFAULT, TUNED])
def test_what_stands_still_is_searched_by_a_tree_of_bounding_volumes_whether_or_not_anything_can_touch(settings: Any) -> None:
    # 50 solids and a floor in one body: a binary tree with so many leaves.
    assert model_of(built(scene_of("system_rays"), settings)).nbvh == 2 * 51 - 1


@pytest.mark.parametrize("case", ["stack_tower", "sensor_lidar_shapes"])
def test_contacts_and_rays_name_the_bodies_whose_shapes_stand_in_the_world(case: str) -> None:
    scene = scene_of(case)
    simulation = built(scene, TUNED)
    model, still = model_of(simulation), [k for k, body in enumerate(scene.bodies) if not body.movable]
    assert still
    for k in still:
        geom = model.geom(f"g{k}.0")
        assert geom.bodyid[0] == 0
        assert simulation._world.indices.owner[geom.id] == k
    simulation.step(2)
    contacts = simulation.contacts()
    assert set(np.concatenate((contacts.body_A, contacts.body_B)).tolist()) <= set(range(len(scene.bodies)))


@pytest.mark.parametrize("ratio", [0.3, 0.5, 1.0, 1.2, 2.0, 5.0])
def test_what_a_contact_gives_is_the_deepest_point_of_its_equation(ratio: float) -> None:
    constant = 0.02
    law = [[0.0, 1.0], [-1 / (constant * ratio) ** 2, -2 / constant]]
    step = expm(np.array(law) * constant / 2000)
    state, deepest = np.array((0.0, 1.0)), 0.0
    while state[1] > 0:
        state = step @ state
        deepest = max(deepest, state[0])
    # The least of a parabola's samples is off by less than an eighth of its curvature over a sample.
    assert give(constant, ratio) == pytest.approx(deepest, rel=1e-5)


@pytest.mark.parametrize(
    ("case", "parameters", "fast"),
    [
        # Pressed as deep as the middle at the closing speed v: v (.00778 s + dt) against half of both widths.
        ("tunnel_sphere_wall", {"speed": 4.5}, False),
        ("tunnel_sphere_wall", {"speed": 4.7}, True),
        ("tunnel_sphere_wall", {"speed": 4.7, "thickness": 0.1}, False),
        ("tunnel_rod", {"spin": 2.5}, False),
        ("tunnel_rod", {"spin": 11.2}, True),
        ("tunnel_dynamic_pair", {"speed": 12.0}, True),
        ("tunnel_thin_mesh", {"speed": 12.0}, True),
        # What is thick, or only slides and turns on the spot, keeps the contacts that do not lift it.
        ("friction_stop", {}, False),
        ("friction_turntable", {}, False),
        ("impact_momentum", {}, False),
    ],
)
def test_contacts_of_two_steps_are_for_what_would_be_pressed_through(case: str, parameters: dict[str, Any], fast: bool) -> None:
    dt = 1 / 240
    told = {"continuous": False, **parameters} if case.startswith("tunnel") else parameters
    simulation = built(scene_of(case, **told), TUNED, dt)
    assert simulation.resolved.options["fast_time_constant"] == (2 * dt if fast else None)
    assert simulation.resolved.options["contact_time_constant"] == min(20 * dt, 0.02)


def test_a_common_drift_makes_nothing_fast() -> None:
    pair = scene_of("tunnel_dynamic_pair", continuous=False, speed=2.0)
    drifting = replace(pair, bodies=tuple(replace(body, v_WB=(body.v_WB[0], 90.0, 0.0)) for body in pair.bodies))
    assert built(drifting, TUNED, 1 / 240).resolved.options["fast_time_constant"] is None


@pytest.mark.parametrize("speed", [12.0, 50.0, 200.0])
def test_pairs_that_speculative_contacts_see_in_time_are_not_pressed_through_either(speed: float) -> None:
    scene = scene_of("tunnel_dynamic_pair", speed=speed)
    simulation = built(scene, TUNED, 1 / 240)
    simulation.step(60)
    x = state_of(simulation, scene).p_WB[:, 0]
    assert int((x[0::2] > x[1::2]).sum()) == 0


@pytest.mark.parametrize("speed", [4.7, 7.0, 12.0])
def test_a_thin_wall_holds_to_12_m_per_s_without_speculative_contacts(speed: float) -> None:
    scene = scene_of("tunnel_sphere_wall", continuous=False, speed=speed)
    simulation = built(scene, TUNED, 1 / 240)
    simulation.step(60)
    assert int((state_of(simulation, scene).p_WB[1:, 0] > 0.005).sum()) == 0


@pytest.mark.parametrize(
    ("case", "steps", "told"),
    [
        # On the inertia that the feet leave, damping times step over it is 2.3, 1.2, 1.9 and .96; without springs 2 is most.
        ("stand_humanoid", 240, "joint"),
        ("stand_humanoid", 480, "actuator"),
        ("stand_quadruped", 120, "joint"),
        ("stand_quadruped", 240, "actuator"),
    ],
)
def test_by_the_step_euler_is_told_the_damping_of_drives_as_that_of_joints_and_machines_stand(
    case: str, steps: int, told: str
) -> None:
    scene = scene_of(case)
    simulation = built(scene, DEFAULT, 1 / steps)
    assert simulation.resolved.options["drive_damping"] == told
    height = state_of(simulation, scene).p_WB[:, 2].max()
    simulation.step(3 * steps)
    assert state_of(simulation, scene).p_WB[:, 2].max() > 0.9 * height
    # The other integrators of that track's ladder take it implicitly; a drive with a limit bounds all of its force.
    assert built(scene, TUNED, 1 / steps).resolved.options["drive_damping"] == "actuator"
    joints = tuple(
        replace(j, drive=replace(j.drive, limit=1e3)) if getattr(j, "drive", None) else j  # type: ignore[union-attr]
        for j in scene.joints
    )
    assert built(replace(scene, joints=joints), DEFAULT, 1 / steps).resolved.options["drive_damping"] == "actuator"


@pytest.mark.parametrize(("ratio", "impedance"), [(100.0, 0.999), (500.0, 0.9999), (1000.0, 0.9999), (2000.0, 0.9999)])
def test_what_bears_many_times_its_weight_stands_on_the_firmest_contacts(ratio: float, impedance: float) -> None:
    scene = scene_of("stack_mass_ratio", ratio=ratio)
    simulation = built(scene, TUNED, 1 / 240)
    assert simulation.resolved.options["contact_impedance"] == impedance
    start = state_of(simulation, scene).p_WB[2, 2]
    simulation.step(480)
    # Two contacts of four corners at a time constant of 20 ms and a damping ratio of 1.2.
    sunk = 2 * (1 - impedance) * (1 + ratio) * G / 4 * (0.02 * 1.2) ** 2
    assert start - state_of(simulation, scene).p_WB[2, 2] == pytest.approx(sunk, rel=2e-2)


@pytest.mark.parametrize("case", ["stack_pile", "stack_pyramid", "stack_tower", "rest_penetration", "stand_quadruped"])
def test_what_bears_its_like_keeps_contacts_that_are_cheap_to_solve(case: str) -> None:
    assert built(scene_of(case), TUNED, 1 / 240).resolved.options["contact_impedance"] == 0.999
    told = replace(TUNED, options={**TUNED.options, "contact_impedance": 0.95})
    assert built(scene_of(case), told, 1 / 240).resolved.options["contact_impedance"] == 0.95


@pytest.mark.parametrize(
    ("case", "impratio"),
    [
        # Balls apart; of a heap; boxes; balls that rebound.
        ("friction_slip_to_roll", 1e-6),
        ("stack_pile", 10.0),
        ("friction_stop", 10.0),
        ("impact_oblique", 10.0),
    ],
)
def test_friction_is_left_to_the_slip_correction_where_balls_touch_what_stands_alone(case: str, impratio: float) -> None:
    """Else what sticks would creep. The vendor's own defaults stay on `default`."""
    used = built(scene_of(case), TUNED).resolved.options
    assert (used["impratio"], used["noslip_iterations"] > 0) == (impratio, impratio < 1)
    assert built(scene_of(case), DEFAULT).resolved.options["impratio"] == 1.0


def test_a_ball_that_slides_into_rolling_neither_hops_nor_leaves_coulomb_s_law_by_more_than_a_step() -> None:
    scene = scene_of("friction_slip_to_roll")
    simulation = built(scene, TUNED, TUNED.dt)
    simulation.step(round(0.3 / TUNED.dt))
    state = state_of(simulation, scene)
    assert state.v_WB[1:, 0] == pytest.approx(5.0 - 0.3 * G * 0.3, abs=1.2 * 0.3 * G * TUNED.dt)
    assert np.abs(state.v_WB[1:, 2]).max() < 1e-3
