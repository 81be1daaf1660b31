"""A parallelogram of two cranks and a coupler that swings through the pose where all three lie in one line.

There its constraints lose a rank: the linkage might go on as an anti-parallelogram. While it stays a parallelogram the coupler
does not turn and the whole is a pendulum with one angle.
"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.bounds import GIVE, G
from plumbline.harness.metrics.conservation import energy_drift_max, energy_drift_staggered_max
from plumbline.harness.metrics.errors import attitude_error_max, position_error_final, position_error_max
from plumbline.harness.metrics.joints import joint_gap_max
from plumbline.harness.scene import WORLD, Body, Effect, Revolute, Scene, box_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about
from plumbline.harness.truths.first_order import FIRST_ORDER, first_order_motions, true_motion
from plumbline.harness.truths.pendulum import swinging

DURATION = 2.5
"""Five times through the line [s]. A first-order method's error grows with the square of the time, and its bound would soon
exceed the linkage."""
CRANK, COUPLER, MASS, THICKNESS = 0.5, 1.0, 1.0, 0.02
HALF_CRANK, HALF_COUPLER = (THICKNESS, THICKNESS, CRANK / 2), (COUPLER / 2, THICKNESS, THICKNESS)


class P(Parameters):
    amplitude: float = 120.0
    """Degrees from hanging; the linkage lies in one line at 90."""


def _rate() -> float:
    """Angular frequency [rad/s] of small swings: two cranks with their weight in the middle, the coupler's at the end."""
    inertia = 2 * (box_inertia(MASS, HALF_CRANK)[1][1] + MASS * CRANK**2 / 4) + MASS * CRANK**2
    return float(np.sqrt((2 * MASS * CRANK / 2 + MASS * CRANK) * G / inertia))


def _placed(time: Floats, theta: Floats, turning: Floats) -> Trajectory:
    """Both cranks and the coupler at crank angles theta [rad] from hanging, towards +x, and rates [rad/s], each (t,)."""
    placed = Trajectory.of(time, 3)
    zero = np.zeros_like(theta)
    along, across = np.stack([np.sin(theta), zero, -np.cos(theta)], 1), np.stack([np.cos(theta), zero, np.sin(theta)], 1)
    for k, (share, x) in enumerate(((0.5, -COUPLER / 2), (0.5, COUPLER / 2), (1.0, 0.0))):
        placed.p_WB[:, k] = share * CRANK * along + np.array([x, 0.0, 0.0])
        placed.v_WB[:, k] = share * CRANK * turning[:, None] * across
    placed.q_WB[:, :2] = about(1, -theta)[:, None]
    placed.w_WB[:, :2, 1] = -turning[:, None]
    return placed


def scene(p: P) -> Scene:
    """Two cranks hinged on the world half a metre left and right of the origin, and the coupler between their ends, at rest."""
    start = _placed(np.zeros(1), np.radians([p.amplitude]), np.zeros(1))
    bodies = tuple(
        Body.box(name, half, mass=MASS, touches=False, p_WB=start.p_WB[0, k].tolist(), q_WB=start.q_WB[0, k].tolist())
        for k, (name, half) in enumerate((("left", HALF_CRANK), ("right", HALF_CRANK), ("coupler", HALF_COUPLER)))
    )
    end = CRANK * np.array([np.sin(np.radians(p.amplitude)), 0.0, -np.cos(np.radians(p.amplitude))])
    axis = (0.0, 1.0, 0.0)
    joints = []
    for name, x in (("left", -COUPLER / 2), ("right", COUPLER / 2)):
        top = (end + np.array([x, 0.0, 0.0])).tolist()
        joints.append(Revolute(name=f"{name}_foot", parent=WORLD, child=name, anchor_W=(x, 0.0, 0.0), axis_W=axis))
        joints.append(Revolute(name=f"{name}_head", parent=name, child="coupler", anchor_W=top, axis_W=axis))
    return Scene(bodies=bodies, joints=tuple(joints), narrow=Effect.GYROSCOPIC)


def expected(time: Floats, p: P) -> Trajectory:
    """The pendulum, by Jacobi's elliptic functions."""
    times = np.asarray(time, dtype=np.float64)
    return _placed(times, *swinging(times, _rate(), np.radians(p.amplitude)))


@lru_cache(maxsize=8)
def _first_order(p: P) -> tuple[float, float, float]:
    """Largest error per dt of position [m/s] and of relative energy [1/s], and the largest speed [m/s]."""

    def acceleration(theta: Floats, _turning: Floats) -> Floats:
        a: Floats = -(_rate() ** 2) * np.sin(theta)
        return a

    times, small, start = np.linspace(0.0, DURATION, 501), 1e-5, [float(np.radians(p.amplitude))]
    true = true_motion(acceleration, start, [0.0], times, 1e-12)
    moved = energy = 0.0
    for other in first_order_motions(acceleration, start, [0.0], times, small):
        moved = max(moved, float(CRANK * np.abs(other[:, 0] - true[:, 0]).max()) / small)
        per_inertia = other[:, 1] ** 2 / 2 - _rate() ** 2 * np.cos(other[:, 0])
        energy = max(energy, float(np.abs(per_inertia - per_inertia[0]).max() / (true[:, 1] ** 2 / 2).max()) / small)
    return moved, energy, float(CRANK * np.abs(true[:, 1]).max())


def _gap(dt: float, p: P) -> float:
    """A step along the tangent leaves the circle by (v dt)^2/(2 r); a solver that takes back a fifth a step keeps five.

    One that closes the loop by a spring of a fixed time constant is off at any step: a millimetre is granted.
    """
    return 5 * (_first_order(p)[2] * dt) ** 2 / (2 * CRANK) + GIVE


def _turned(dt: float, p: P) -> float:
    """In one line a gap g lets the coupler turn by sqrt(8 g/r), since distances change there in second order only; the crank
    errs by its own way besides."""
    return float(np.sqrt(8 * _gap(dt, p) / CRANK)) + 2 * _first_order(p)[0] * dt / CRANK


def _position(dt: float, p: P) -> float:
    """The way of a crank's end, and the gap."""
    return 2 * _first_order(p)[0] * dt + _gap(dt, p)


CASE = Case.of(
    globals(),
    title="Four-bar linkage",
    question="Does a closed loop with redundant constraints hold together and go on as a parallelogram through its singular "
    "pose?",
    source="McCarthy, Soh, Geometric Design of Linkages, 2nd ed., section 2.4 (change point); the pendulum by elliptic "
    "functions",
    truth="closed form",
    converges="smoothly",
    scale=CRANK,
    checks=(
        Check(position_error_max, _position, FIRST_ORDER),
        Check(energy_drift_max, lambda dt, p: 2 * _first_order(p)[1] * dt, FIRST_ORDER),
        Check(
            attitude_error_max,
            _turned,
            "where all lies in one line a gap g lets the coupler turn by sqrt(8 g/r), to which the cranks' own error "
            "is added; as an anti-parallelogram it would turn by more than a radian",
        ),
        Check(
            joint_gap_max,
            _gap,
            "a step along the tangent leaves the circle by (v dt)^2/(2 r), of which a solver that corrects a fifth a "
            "step keeps five; and a millimetre, which a joint may give way that closes a loop by a spring: one of a fixed "
            "time constant T = 0.02 s is off by T^2 times the acceleration that it does not foresee, at any step",
        ),
    ),
    observe=(position_error_final, energy_drift_staggered_max),
)
