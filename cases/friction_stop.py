"""Boxes sliding to a stop on level ground.

A box with speed v0 slows by mu g and stops after d = v0^2/(2 mu g) at t = v0/(mu g), whatever its mass and shape.
Source: Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., section 3/4.
"""

import numpy as np

from plumbline.harness.case import ByParameters, Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import GIVE, G, forces_keep_momentum, forces_obey_coulomb
from plumbline.harness.metrics import jitter, slide
from plumbline.harness.scene import Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

MASS, SPACING = 1.0, 1.0
HALF = (0.2, 0.2, 0.05)
"""Half extents [m], so flat that friction at the base tips no box: mu times the centre's height stays under the half length."""


class P(Parameters):
    frictions: tuple[float, ...] = (0.2, 0.4, 0.7)
    speed: Positive = 2.0


def stretch(p: P) -> float:
    """The longest slide over that of the case's own parameters [1]: what the run and the rest after it are stretched by."""
    return p.speed / min(mu for mu in p.frictions if mu > 0) / (P().speed / min(P().frictions))


def scene(p: P) -> Scene:
    """One box for each coefficient, side by side along y, touching the ground and moving along x at `speed` [m/s]."""
    materials = [f"box_{i}" for i in range(len(p.frictions))]
    boxes = [
        Body.box(f"box_{i}", HALF, mass=MASS, material=materials[i], p_WB=(0.0, SPACING * i, HALF[2]), v_WB=(p.speed, 0.0, 0.0))
        for i in range(len(p.frictions))
    ]
    return Scene(
        bodies=(Body.ground(), *boxes),
        surfaces=tuple(Surface.rough(mu, (m, "ground")) for m, mu in zip(materials, p.frictions, strict=True)),
        apart=tuple((a, b) for i, a in enumerate(materials) for b in materials[i + 1 :]),
        # Boxes that slide flat never turn, so that no gyroscopic torque is asked for.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: uniform deceleration, then rest."""
    truth = Trajectory.at_rest(scene(p), time)
    for i, mu in enumerate(p.frictions, start=1):
        sliding = truth.time if mu == 0 else np.minimum(truth.time, p.speed / (mu * G))
        truth.p_WB[:, i, 0] = p.speed * sliding - mu * G * sliding**2 / 2
        truth.v_WB[:, i, 0] = p.speed - mu * G * sliding
    return truth


CASE = Case.of(
    globals(),
    title="Sliding to a stop",
    question="Does a sliding box stop where and when Coulomb's law says, and stay on the ground on its way?",
    source="Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., section 3/4",
    truth="closed form",
    duration=ByParameters(lambda p: 1.5 * stretch(p)),
    sample_interval=1 / 240,
    checks=(
        Check(
            slide.stop_distance_error,
            lambda dt, p: 1.5 * p.speed * dt / (p.speed**2 / (2 * max(p.frictions) * G)),
            "a staggered scheme places the box half a step's way v0 dt/2 off, and the first step may pass before there "
            "is a contact to rub, one way v0 dt more; relative to the shortest way v0^2/(2 mu g), mu = 0.7",
        ),
        Check(
            slide.stop_time_error,
            lambda dt, p: (dt + dt.outer) / (0.9 * p.speed / (max(p.frictions) * G)),
            "one step without a contact at the start, the resolution of what is told at the end; relative to the "
            "shortest time to a tenth of the speed, 0.9 v0/(mu g), mu = 0.7",
        ),
        Check(
            slide.centre_rise,
            lambda dt, _: G * dt**2 + GIVE,
            "nothing pushes a sliding box up; a contact that is lost is regained in the next step, in which the box "
            "moves at most g dt for dt; and one that gives way by a millimetre may swing up by as much",
        ),
        Check(
            jitter.rms_speed,
            lambda dt, p: min(p.frictions) * G * dt,
            "friction takes any speed under mu g dt within a step, so none is left once all have stopped (t = 1.02 s at 2 m/s)",
            start=ByParameters(lambda p: 1.25 * stretch(p)),
        ),
        forces_keep_momentum(),
        *forces_obey_coulomb(),
    ),
    converges="once",
)
