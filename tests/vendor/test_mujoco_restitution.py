"""An oblique impact in MuJoCo's own words: it has no restitution, so that a spring and a damper stand in for it.

solref in its direct form is a stiffness and a damping per unit mass. A contact cannot pull, and lasts several steps: for a
rebound of e the damping ratio is found here by MuJoCo itself, as the mean over the phases of the step. Friction has a time
constant of its own, solreffriction: as long as the impact, e^-2 of a slip that could be stopped is left; a faster one presses
the ball away.

Source: MuJoCo, "Modeling", restitution and solver parameters (direct format; friction).
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

from tests.vendor.mujoco_world import make_spec, mujoco, on_plane

pytestmark = pytest.mark.mujoco

DT, RADIUS, APPROACH, RESTITUTION, FRICTION = 1 / 240, 0.2, 2.0, 0.6, 0.3
BALLS = (
    ((1.0, 0.0), (0.0, 0.0, 0.0)),
    ((2.0, 2.0), (0.0, 0.0, 0.0)),
    ((6.0, 0.0), (0.0, 0.0, 0.0)),
    ((-4.0, 4.0), (0.0, 0.0, 0.0)),
    ((1.0, 0.0), (0.0, -10.0, 0.0)),
    ((2.0, 0.0), (0.0, -30.0, 0.0)),
    ((0.0, 0.0), (10.0, 5.0, 15.0)),
)
"""Velocity along the ground [m/s] and spin [rad/s]: grip, slip, backspin that grips and slips, spin alone."""
PHASES = (np.arange(8) + 0.5) / 8


def thrown(
    solref: tuple[float, float], steps: int, friction_steps: float, phase: float, v: tuple[float, float], w: tuple[float, ...]
) -> Any:
    """Velocity and angular velocity (6,) [m/s, rad/s] of a ball that came down at 2 m/s, well after it left the ground."""

    def settle(pair: Any) -> None:
        rough = any(v) or any(w)
        pair.condim, pair.friction = (3 if rough else 1), (FRICTION, FRICTION, 0.0, 0.0, 0.0)
        pair.solref, pair.solimp = solref, (0.9999, 0.9999, 0.001, 0.5, 2.0)
        pair.solreffriction = (friction_steps * DT, 1.0)

    place = (0.0, 0.0, RADIUS + (3 + phase) * APPROACH * DT)
    sphere = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": (RADIUS, 0.0, 0.0)}
    model, data = on_plane(make_spec(DT, gravity=0.0, impratio=10.0, tolerance=1e-10), place, settle, **sphere)
    data.qvel[:] = (*v, -APPROACH, *w)
    mujoco.mj_step(model, data, 3 * steps + 20)
    # A free joint's rotation is told in the body's axes.
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    return np.concatenate([data.qvel[:3], turn.reshape(3, 3) @ data.qvel[3:]])


def solref_of(ratio: float, steps: int) -> tuple[float, float]:
    """Stiffness and damping of a contact that presses for so many steps."""
    angle = math.asin(ratio)
    rate = (math.pi - 2 * angle) / (math.cos(angle) * steps * DT)
    return -(rate**2), -2 * ratio * rate


@cache
def elastic(steps: int) -> tuple[float, float]:
    """The solref whose mean rebound is e, by bisection."""

    def rebound(ratio: float) -> float:
        up = [thrown(solref_of(ratio, steps), steps, 2.0, phase, (0.0, 0.0), (0.0, 0.0, 0.0))[2] for phase in PHASES]
        return float(np.mean(up)) / APPROACH

    low, high = 1e-6, 0.6
    for _ in range(16):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > RESTITUTION else (low, middle)
    return solref_of(low, steps)


def struck(v: tuple[float, float], w: tuple[float, ...]) -> Any:
    """Newton's and Coulomb's impulse on a homogeneous ball of 1 kg: velocity and angular velocity (6,) after it."""
    before, spin, moment = np.array([*v, -APPROACH]), np.array(w), 0.4 * RADIUS**2
    arm = np.array([0.0, 0.0, -RADIUS])
    slip = (before + np.cross(spin, arm)) * (1.0, 1.0, 0.0)
    normal = (1 + RESTITUTION) * APPROACH
    # What stops the slip: 1/m + r^2/I is 7/2 of 1/m.
    rub = -slip / 3.5
    size = float(np.linalg.norm(rub))
    rub *= min(1.0, FRICTION * normal / size) if size > 0 else 1.0
    return np.concatenate([before + rub + (0.0, 0.0, normal), spin + np.cross(arm, rub) / moment])


@cache
def worst(steps: int, friction_steps: float) -> float:
    """Largest error of the velocity after the impact over the speed of approach, of seven balls, the mean over phases."""
    errors = [
        np.mean(
            [
                np.linalg.norm((thrown(elastic(steps), steps, friction_steps, phase, v, w) - struck(v, w))[:3])
                for phase in PHASES
            ]
        )
        for v, w in BALLS
    ]
    return float(max(errors)) / APPROACH


def test_nothing_in_mujoco_is_called_restitution() -> None:
    spec = mujoco.MjSpec()
    pair, geom = spec.add_pair(), spec.worldbody.add_geom()
    assert not [name for one in (spec, spec.option, geom, pair) for name in dir(one) if "restitution" in name.lower()]


@pytest.mark.parametrize("steps", [10, 40])
def test_a_spring_and_a_damper_rebound_by_e_in_the_mean_over_the_phases_of_the_step(steps: int) -> None:
    up = [thrown(elastic(steps), steps, 2.0, phase, (0.0, 0.0), (0.0, 0.0, 0.0))[2] for phase in PHASES]
    # Bisected to 2^-16 of the damping ratio; one phase strays by the share of the impact that a step is, or less.
    assert np.mean(up) / APPROACH == pytest.approx(RESTITUTION, abs=1e-4)
    assert np.ptp(up) / APPROACH < 1 / steps


def test_an_oblique_impact_errs_by_less_than_a_tenth_where_friction_is_as_slow_as_a_slow_impact() -> None:
    # Grip leaves e^(-2/1.5) of its slip and slip presses the ball away: of both, one and a half impacts leave the least.
    assert worst(40, 60.0) < 0.1
    assert worst(40, 60.0) < worst(40, 40.0) < worst(40, 20.0)
    assert worst(40, 60.0) < worst(40, 80.0)


def test_a_longer_impact_errs_less_than_a_short_one_whose_friction_is_as_slow() -> None:
    assert worst(40, 40.0) < worst(20, 20.0) < worst(10, 10.0)
