"""The truths of the cases that the scaling study clocks, by hand or by another route; each planted fault fails its check."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.cases import flight_box, joint_chain, rest_penetration, stack_pile, system_rays
from plumbline.harness.case import Case, Converged
from plumbline.harness.scene import rotation_matrix
from plumbline.harness.trajectory import Contacts, Trajectory
from plumbline.harness.truths import pendulum

G = 9.81


def verdicts(case: Case, run: Trajectory, **parameters: Any) -> dict[str, bool]:
    chosen = dict(case.parameters) | parameters
    truth = case.truth_at(run.time, chosen)
    expected = truth.trajectory if isinstance(truth, Converged) else truth
    scene = case.scene(case.at(**chosen))
    return {
        c.metric.name: c.passes(c.metric(scene, run.between(c.start, 99.0), expected), run.dt, case.parameters)
        for c in case.checks
    }


# --- stack_pile -----------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 10, 100, 1000])
def test_the_packing_touches_everywhere_and_nothing_overlaps(n: int) -> None:
    centres = stack_pile.packing(n)
    assert len(centres) == n
    apart = np.linalg.norm(centres[:, None] - centres[None, :], axis=2) + 9.0 * np.eye(n)
    # Every ball touches another, in units of a radius, and stands on the floor or in the hollow of four.
    assert apart.min() == pytest.approx(2.0, abs=1e-12) or n == 1
    below = ((centres[None, :, 2] < centres[:, None, 2] - 0.5) & (np.abs(apart - 2.0) < 1e-12)).sum(axis=1)
    assert np.all((centres[:, 2] == 1.0) | (below >= 1))
    assert np.abs(centres[:, :2]).max() + 1.0 <= stack_pile.side(n) + 1e-12


def test_an_inner_ball_touches_twelve_others() -> None:
    centres = stack_pile.packing(1000)
    middle = centres[np.argmin(np.linalg.norm(centres - centres.mean(axis=0), axis=1))]
    touching = np.abs(np.linalg.norm(centres - middle, axis=1) - 2.0) < 1e-12
    assert touching.sum() == 12


def test_a_heap_is_about_as_high_as_it_is_wide() -> None:
    centres = stack_pile.packing(10_000)
    assert centres[:, 2].max() + 1.0 == pytest.approx(2.0 * stack_pile.side(10_000), rel=0.2)


def pile(n: int = 20) -> Trajectory:
    run = replace(stack_pile.expected(np.arange(21) / 20, stack_pile.P(n=n)), dt=1 / 240)
    return replace(run, streams={"worlds/time": np.ones(1), "worlds/spread": np.zeros(1)})


def test_a_pile_at_rest_passes_and_each_fault_fails_its_own_check() -> None:
    assert all(verdicts(stack_pile.CASE, pile(), n=20).values())
    out = pile()
    out.p_WB[15, 7] = (5.0, 0.0, 0.05)
    assert not verdicts(stack_pile.CASE, out, n=20)["overlap"]
    moving = pile()
    moving.v_WB[:, 9, 0] = 0.1
    assert not verdicts(stack_pile.CASE, moving, n=20)["rms_speed"]
    parted = replace(pile(), streams={"worlds/time": np.ones(1), "worlds/spread": np.array([1e-15])})
    assert not verdicts(stack_pile.CASE, parted, n=20)["world_spread"]


# --- rest_penetration -----------------------------------------------------------------------------


def resting(shape: str) -> Trajectory:
    run = replace(rest_penetration.expected(np.arange(121) / 60, rest_penetration.P(shape)), dt=1 / 240)
    contacts = Contacts.of([0], [1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], [0.0], [[0.0, 0.0, G]])
    return replace(run, contacts=(contacts,) * len(run))


@pytest.mark.parametrize("shape", ["box", "sphere", "cylinder", "capsule"])
def test_each_shape_touches_the_ground_at_its_lowest_point(shape: str) -> None:
    body = rest_penetration.scene(rest_penetration.P(shape)).bodies[1]
    placed = body.collision[0].shape
    down = np.array(rotation_matrix(body.q_WB)).T @ (0.0, 0.0, -1.0)
    half = getattr(placed, "half_length", 0.0)
    reach = {
        "box": lambda: float(np.abs(down) @ np.array(placed.half_extents)),  # type: ignore[union-attr]
        "sphere": lambda: placed.radius,  # type: ignore[union-attr]
        "cylinder": lambda: half * abs(down[2]) + placed.radius * math.hypot(down[0], down[1]),  # type: ignore[union-attr]
        "capsule": lambda: half * abs(down[2]) + placed.radius,  # type: ignore[union-attr]
    }[shape]()
    assert body.p_WB[2] == pytest.approx(reach, abs=1e-15)
    assert all(verdicts(rest_penetration.CASE, resting(shape), shape=shape).values())


def test_a_body_that_sinks_hovers_trembles_or_is_not_borne_fails() -> None:
    run = resting("box")
    # g dt^2 and a millimetre are granted, 1.17 mm in all at 1/240 s; what the engine reports of its contacts is not judged.
    for sunk, holds in ((1.1e-3, True), (1.25e-3, False)):
        deep = resting("box")
        deep.p_WB[:, 1, 2] -= sunk
        assert verdicts(rest_penetration.CASE, deep)["penetration"] == holds
    hovers = resting("box")
    hovers.p_WB[:, 1, 2] += np.where(hovers.time > 0, 2e-3, 0.0)
    assert verdicts(rest_penetration.CASE, hovers)["penetration"]
    assert not verdicts(rest_penetration.CASE, hovers)["rest_drift"]
    told = replace(run.contacts[0], gap=np.array([-0.05]))  # type: ignore[index]
    assert all(verdicts(rest_penetration.CASE, replace(run, contacts=(told,) * len(run))).values())
    light = replace(run.contacts[0], force_W=np.array([[0.0, 0.0, 0.9 * G]]))  # type: ignore[index]
    assert not verdicts(rest_penetration.CASE, replace(run, contacts=(light,) * len(run)))["support_force_error"]
    run.v_WB[:, 1, 2] = 0.05
    assert not verdicts(rest_penetration.CASE, run)["rms_speed"]


# --- flight_box -----------------------------------------------------------------------------------


def test_the_free_box_has_the_derivatives_that_its_equations_say() -> None:
    time = np.linspace(0.0, 1.0, 1001)
    truth = flight_box.expected(time, flight_box.P())
    h = time[1]
    slope = (truth.p_WB[2:, 0] - truth.p_WB[:-2, 0]) / (2 * h)
    np.testing.assert_allclose(slope, truth.v_WB[1:-1, 0], atol=1e-11)  # exact for a parabola, but for 1e-16/h of rounding
    turn = (truth.q_WB[2:, 0] - truth.q_WB[:-2, 0]) / (2 * h)
    z = np.stack([-truth.q_WB[:, 0, 3], truth.q_WB[:, 0, 0]], axis=1)  # q (0, 0, 0, 1) has these w and z
    np.testing.assert_allclose(turn[:, [0, 3]], 0.5 * truth.w_WB[1:-1, 0, 2:] * z[1:-1], atol=h**2)


def test_a_box_that_is_braked_or_turned_fails() -> None:
    time = np.arange(61) / 60
    fine = replace(flight_box.expected(time, flight_box.P()), dt=1 / 240)
    assert all(verdicts(flight_box.CASE, fine).values())
    braked = flight_box.expected(time, flight_box.P())
    braked.v_WB[:, 0] *= np.exp(-0.04 * time)[:, None]
    assert not verdicts(flight_box.CASE, replace(braked, dt=1 / 240))["velocity_error_max"]
    slow = flight_box.expected(time, flight_box.P(spin=1.99))
    found = verdicts(flight_box.CASE, replace(slow, dt=1 / 240))
    assert not found["attitude_error_max"]
    assert not found["angular_velocity_error_max"]


# --- joint_chain ----------------------------------------------------------------------------------


def test_two_links_obey_the_equations_of_the_double_pendulum(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rods of that case's length and inertia, by equations that were written down for two rods alone."""
    monkeypatch.setattr(joint_chain, "LENGTH", pendulum.LENGTH)
    monkeypatch.setattr(joint_chain, "INERTIA", pendulum.INERTIA)
    rng = np.random.default_rng(1)
    for _ in range(20):
        theta, rate = rng.uniform(-2, 2, 2), rng.uniform(-3, 3, 2)
        np.testing.assert_allclose(
            joint_chain.acceleration(theta, rate), pendulum.acceleration(theta, rate), rtol=1e-11, atol=1e-11
        )


def test_the_reference_of_a_long_chain_keeps_its_energy_and_its_links() -> None:
    time = np.arange(121) / 60
    truth = joint_chain.expected(time, joint_chain.P()).trajectory
    kinetic, potential = joint_chain.energy(truth)
    drift = np.abs(kinetic + potential - potential[0]).max() / kinetic.max()
    assert drift < 1e-9  # a tolerance of 1e-12 over some hundred steps, summed over ten links
    along = np.diff(truth.p_WB, axis=1)
    assert np.linalg.norm(along, axis=2).max() <= joint_chain.LENGTH * (1 + 1e-12)
    assert joint_chain.expected(time, joint_chain.P()).position_error < 1e-7


def test_a_single_link_has_the_acceleration_of_a_physical_pendulum() -> None:
    theta = np.array([0.7])
    moment = joint_chain.INERTIA + joint_chain.MASS * joint_chain.LENGTH**2 / 4
    expected = -joint_chain.MASS * G * joint_chain.LENGTH / 2 * math.sin(0.7) / moment
    assert joint_chain.acceleration(theta, np.zeros(1))[0] == pytest.approx(expected, rel=1e-12)


def test_a_chain_that_is_braked_or_comes_apart_fails() -> None:
    time = np.arange(121) / 60
    fine = replace(joint_chain.expected(time, joint_chain.P()).trajectory, dt=1 / 240)
    assert all(verdicts(joint_chain.CASE, fine).values())
    torn = replace(fine, p_WB=fine.p_WB.copy())
    torn.p_WB[60:, 5:, 0] += 0.01
    assert not verdicts(joint_chain.CASE, torn)["joint_gap_max"]
    slow = replace(fine, v_WB=0.9 * fine.v_WB, w_WB=0.9 * fine.w_WB)
    assert not verdicts(joint_chain.CASE, slow)["energy_drift_max"]


# --- system_rays ----------------------------------------------------------------------------------


def test_the_yard_has_51_primitives_of_which_none_holds_the_eye() -> None:
    stage = system_rays.scene(system_rays.P())
    shapes = [placed for body in stage.bodies for placed in body.collision]
    assert len(shapes) == 51
    for body in stage.bodies[1:-1]:
        assert math.hypot(body.p_WB[0], body.p_WB[1]) > 2.0  # the largest shape reaches 1 m from its centre


@pytest.mark.parametrize(("pattern", "count"), [("lidar", 32 * 1024), ("depth", 640 * 480)])
def test_rays_are_unit_vectors_and_as_many_as_the_sensor_has(pattern: str, count: int) -> None:
    rays = system_rays.rays(system_rays.P(pattern))
    assert rays.directions.shape == rays.origins.shape == (count, 3)
    np.testing.assert_allclose(np.linalg.norm(rays.directions, axis=1), 1.0, atol=4e-16)


def test_most_rays_meet_something_and_a_range_moved_by_a_millimetre_fails() -> None:
    truth = system_rays.expected(np.array([0.0, 0.1]), system_rays.P(thin=16))
    found = truth.streams["rays/range_ideal"]
    assert 0.5 < np.isfinite(found).mean() < 1.0
    run = replace(truth, dt=1 / 240)
    assert all(verdicts(system_rays.CASE, run, thin=16).values())
    moved = replace(run, streams=dict(run.streams) | {"rays/range_ideal": found + 1e-3})
    assert not verdicts(system_rays.CASE, moved, thin=16)["range_error_median"]
    blind = replace(run, streams=dict(run.streams) | {"rays/range_ideal": np.where(found < 3.0, np.inf, found)})
    assert not verdicts(system_rays.CASE, blind, thin=16)["range_false_return_share"]


def test_an_unknown_pattern_is_named() -> None:
    with pytest.raises(ValueError, match="'sonar', expected 'lidar' or 'depth'"):
        system_rays.rays(system_rays.P("sonar"))
