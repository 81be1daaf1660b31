"""The driven crowd: its forces are the same for all, its flight a chain of parabolas, its scenes as large as they say."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.system_scaling import CASE, INTERVAL, KINDS, MASS, PUSH, TWIST, P, control, expected, noise, scene
from plumbline.harness.metrics.joints import joint_gap_max
from plumbline.harness.trajectory import Floats, State, Trajectory


def test_the_flight_obeys_newtons_law_under_the_forces_that_are_told() -> None:
    time = np.linspace(0.0, 0.5, 41)
    truth = expected(time, P("flight", n=3))
    assert truth is not None
    law, stage = control(P("flight", n=3)), scene(P("flight", n=3))
    p, v, found = State.initial(stage).p_WB, np.zeros((3, 3)), [State.initial(stage).p_WB]
    for begin, end in pairwise(time):
        # Within an interval the force is constant; an integration from sample to sample must be cut where it changes.
        for a, b in _cut(float(begin), float(end)):
            force = law.wrench(round(a / INTERVAL - 0.499999) * INTERVAL, State.initial(stage))[0]

            def change(_t: float, y: Floats, push: Floats = force) -> Floats:
                return np.concatenate([y[9:], push.ravel() / MASS])

            y = solve_ivp(change, (a, b), np.concatenate([p.ravel(), v.ravel()]), "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
            p, v = y[:9].reshape(3, 3), y[9:].reshape(3, 3)
        found.append(p)
    np.testing.assert_allclose(truth.p_WB, np.array(found), atol=1e-12)
    np.testing.assert_allclose(truth.v_WB[-1], v, atol=1e-11)


def _cut(begin: float, end: float) -> list[tuple[float, float]]:
    edges = [k * INTERVAL for k in range(100) if begin + 1e-9 < k * INTERVAL < end - 1e-9]
    places = [begin, *edges, end]
    return list(pairwise(places))


def test_the_noise_repeats_for_each_seed_spreads_as_it_says_and_does_not_depend_on_the_crowd() -> None:
    np.testing.assert_array_equal(noise(7, 5, seed=1)[0], noise(7, 5, seed=1)[0])
    np.testing.assert_array_equal(noise(7, 50, seed=1)[1][:5], noise(7, 5, seed=1)[1])
    assert not np.array_equal(noise(7, 5, seed=1)[0], noise(8, 5, seed=1)[0])
    assert not np.array_equal(noise(7, 5, seed=1)[0], noise(7, 5, seed=2)[0])
    force, torque = noise(0, 10_000, seed=0)
    # 30000 draws: the spread of a spread is 1/sqrt(60000), 0.4 %.
    assert force.std() == pytest.approx(PUSH, rel=0.02)
    assert torque.std() == pytest.approx(TWIST, rel=0.02)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [1, 8, 30])
def test_each_scene_has_n_bodies_that_are_pushed(kind: str, n: int) -> None:
    stage = scene(P(kind, n))
    assert sum(body.movable for body in stage.bodies) == n
    force, torque = control(P(kind, n)).wrench(0.0, State.initial(stage))
    assert force.shape == torque.shape == (len(stage.bodies), 3)
    assert all(bool(push.any()) == body.movable for push, body in zip(force, stage.bodies, strict=True))
    if kind == "chain":
        start = Trajectory.of(np.zeros(1), n)
        start.p_WB[0] = State.initial(stage).p_WB
        assert joint_gap_max(stage, start) < 1e-14
    if kind == "contact":
        places = np.array([body.p_WB for body in stage.bodies[1:]])
        apart = np.abs(places[:, None] - places[None]).max(axis=2) + 9 * np.eye(n)
        assert apart.min() > 0.2  # an edge: no two cubes overlap


def test_an_unknown_kind_is_named() -> None:
    with pytest.raises(ValueError, match="'crowd', expected one of flight, contact, chain"):
        scene(P("crowd"))


def test_what_leaves_its_way_overlaps_or_comes_apart_fails() -> None:
    time = np.arange(61) / 60
    checks = {check.metric.name: check for check in CASE.checks}

    def passes(name: str, kind: str, run: Trajectory) -> bool:
        check = checks[name]
        return check.passes(check.metric(scene(P(kind)), run, expected(time, P(kind))), 1 / 240, CASE.parameters)

    truth = expected(time, P("flight"))
    assert truth is not None
    flight = replace(truth, dt=1 / 240)
    assert passes("position_error_max", "flight", flight)
    # Semi-implicit Euler: p moves by the new velocity of each step, which is dt/2 (v - v0) ahead.
    ahead = replace(flight, p_WB=flight.p_WB + flight.v_WB / 480)
    assert passes("position_error_max", "flight", ahead)
    assert not passes("position_error_max", "flight", replace(flight, p_WB=flight.p_WB + 0.1))
    crowd = replace(Trajectory.of(time, 11), dt=1 / 240)
    crowd.p_WB[:] = State.initial(scene(P("contact"))).p_WB
    assert passes("inscribed_overlap", "contact", crowd)
    crowd.p_WB[30, 1] = crowd.p_WB[30, 2]
    assert not passes("inscribed_overlap", "contact", crowd)
    chain = replace(Trajectory.of(time, 10), dt=1 / 240)
    chain.p_WB[:] = State.initial(scene(P("chain"))).p_WB
    assert passes("joint_gap_max", "chain", chain)
    chain.p_WB[30, 4, 0] += 0.05
    assert not passes("joint_gap_max", "chain", chain)
