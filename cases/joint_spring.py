"""Masses on springs and dampers: do they swing and creep back as their damping ratio says, and is no damping added?"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Parameters, Positive
from plumbline.harness.metrics import errors
from plumbline.harness.metrics.joints import joint_gap_max
from plumbline.harness.scene import WORLD, Body, Effect, Prismatic, Scene, Spring
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.first_order import FIRST_ORDER, first_order_motions, true_motion

DURATION = 5.0
RATE = 6.0
"""Undamped angular frequency [rad/s]."""
STRETCH, MASS, SPACING = 0.3, 1.0, 0.5
HALF = (0.1, 0.1, 0.1)


class P(Parameters):
    ratios: tuple[float, ...] = (0.1, 1.0, 2.0)
    """Damping over critical damping: it swings, it just does not, it creeps."""
    rate: Positive = RATE
    stretch: float = STRETCH


def scene(p: P) -> Scene:
    """One mass for each damping ratio, side by side, on a rail along x, released `stretch` [m] from its spring's rest."""
    bodies, joints = [], []
    for k, ratio in enumerate(p.ratios):
        centre = (p.stretch, SPACING * k, 0.0)
        bodies.append(Body.box(f"mass_{k}", HALF, mass=MASS, touches=False, p_WB=centre))
        joints.append(
            Prismatic(
                name=f"rail_{k}",
                parent=WORLD,
                child=f"mass_{k}",
                anchor_W=centre,
                axis_W=(1.0, 0.0, 0.0),
                position=p.stretch,
                spring=Spring(stiffness=MASS * p.rate**2, damping=2 * MASS * p.rate * ratio),
            )
        )
    # Nothing turns on a rail.
    return Scene(bodies=tuple(bodies), joints=tuple(joints), gravity=(0.0, 0.0, 0.0), narrow=Effect.GYROSCOPIC)


def _motion(time: Floats, ratio: float, rate: float, stretch: float) -> tuple[Floats, Floats]:
    """x [m] and x' [m/s] of x'' + 2 ratio rate x' + rate^2 x = 0 from rest at `stretch`, each (t,)."""
    fading = ratio * rate
    if ratio < 1:
        swing = rate * np.sqrt(1 - ratio**2)
        decay = stretch * np.exp(-fading * time)
        x = decay * (np.cos(swing * time) + fading / swing * np.sin(swing * time))
        return x, -decay * rate**2 / swing * np.sin(swing * time)
    if ratio == 1:
        decay = stretch * np.exp(-rate * time)
        return decay * (1 + rate * time), -decay * rate**2 * time
    apart = rate * np.sqrt(ratio**2 - 1)
    # The two roots, the slower written without the difference of two nearly equal numbers.
    fast = -(fading + apart)
    slow = rate**2 / fast
    one, two = np.exp(slow * time), np.exp(fast * time)
    return stretch * (fast * one - slow * two) / (fast - slow), stretch * slow * fast * (one - two) / (fast - slow)


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form of the damped oscillator."""
    truth = Trajectory.at_rest(scene(p), time)
    for k, ratio in enumerate(p.ratios):
        truth.p_WB[:, k, 0], truth.v_WB[:, k, 0] = _motion(truth.time, ratio, p.rate, p.stretch)
    return truth


@lru_cache(maxsize=16)
def _first_order(p: P) -> Floats:
    """Largest error per dt of position [m/s] and of velocity [m/s2], the worst of the masses, (2,).

    In units of 1/rate the motion is the same at any rate, and as long as at the default one it has long shown its largest
    error: what fades only then is damped by less than the default ones.
    """
    scale, worst = max(1.0, p.rate / RATE), np.zeros(2)
    times, small = np.linspace(0.0, DURATION / scale, 501), 1e-5 / scale
    for ratio in p.ratios:

        def acceleration(x: Floats, v: Floats, ratio: float = ratio) -> Floats:
            a: Floats = -(p.rate**2) * x - 2 * ratio * p.rate * v
            return a

        true = true_motion(acceleration, [p.stretch], [0.0], times, 1e-12)
        for other in first_order_motions(acceleration, [p.stretch], [0.0], times, small):
            worst = np.maximum(worst, np.abs(other - true).max(axis=0) / small)
    return worst


CASE = Case.of(
    globals(),
    title="Spring and damper",
    question="Does a mass on a spring and damper move as its damping ratio says, below, at and above the critical one?",
    source="Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., section 8/2",
    truth="closed form",
    hard=Axis(parameter="rate", unit="rad/s", easy=6.0, extreme=6e4, lost=1.0),
    converges="smoothly",
    scale=STRETCH,
    checks=(
        Check(errors.position_error_max, lambda dt, p: float(2 * _first_order(p)[0]) * dt, FIRST_ORDER),
        Check(errors.velocity_error_max, lambda dt, p: float(2 * _first_order(p)[1]) * dt, FIRST_ORDER),
        Check(joint_gap_max, 1e-6, "nothing pushes a mass off its rail; 1e-6 m is single-precision rounding"),
        Check(errors.attitude_error_max, 1e-6, "nothing turns a mass on its rail; single-precision rounding"),
    ),
    observe=(errors.position_error_rms, errors.position_error_final),
)
