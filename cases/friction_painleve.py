"""A slender rod pushed over rough ground, its foot ahead: at mu = 4/3 Coulomb's law and rigidity contradict each other.

With the rod at an angle a to the ground, sliding foot first, the load N on its foot obeys A N = m (g - l w^2 sin a) with

    A = 1 + 3 cos^2 a - 3 mu sin a cos a.

Below mu = 4/3 A is positive at every angle. Above it there are angles, 63.43 degrees (tan a = 2) the first of them, where A is
negative: no load that pushes holds the foot on the ground, and none lets it leave. In nature, and in engines that solve for
impulses, the foot then stops in a single blow: from 8 m/s by 3.2 N s along and 2.4 N s off the ground, in the ratio of 4/3.
Source: Painleve, C. R. Acad. Sci. 121 (1895) 112; Genot and Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653; Stewart, SIAM
Review 42 (2000) 3.
"""

from functools import lru_cache

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Converged, NotNegative, Parameters
from plumbline.harness.case.bounds import G, forces_keep_momentum, forces_obey_coulomb
from plumbline.harness.metrics import conservation, contacts, errors, slide
from plumbline.harness.scene import Body, Capsule, Effect, PlacedShape, Scene, Sphere, Surface, principal_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.first_order import FIRST_ORDER, first_order_motions, true_motion

MASS, HALF, RADIUS = 1.0, 1.0, 0.01
"""Half the length [m] of the rod between the centres of its rounded ends; these shift the critical friction by 1 %."""
INERTIA = MASS * HALF**2 / 3
DURATION = 0.125


class P(Parameters):
    friction: NotNegative = 1.0
    speed: float = 8.0
    angle: float = float(np.degrees(np.arctan(2.0)))
    """Degrees between the rod and the ground: the angle at which the least friction suffices for the paradox."""


def scene(p: P) -> Scene:
    """A rod on its foot at `angle` [degrees] to the ground, leaning towards +x and sliding at `speed` [m/s] towards -x."""
    a = float(np.radians(p.angle))
    ends = tuple(PlacedShape(shape=Sphere(radius=RADIUS), p_BS=(0.0, 0.0, side * HALF)) for side in (-1, 1))
    rod = Body(
        name="rod",
        mass=MASS,
        inertia=principal_inertia(INERTIA, INERTIA, MASS * RADIUS**2 / 2),
        collision=ends,
        visual=(PlacedShape(shape=Capsule(radius=RADIUS, half_length=HALF)),),
        material="rod",
        p_WB=(0.0, 0.0, RADIUS + HALF * float(np.sin(a))),
        q_WB=_attitude(np.array(a)).tolist(),
        v_WB=(-p.speed, 0.0, 0.0),
    )
    law = Surface.rough(p.friction, ("rod", "ground"))
    return Scene(bodies=(Body.ground(), rod), surfaces=(law,), narrow=Effect.GYROSCOPIC)


def _attitude(a: Floats) -> Floats:
    """The rod's z axis along (cos a, 0, sin a): turned by pi/2 - a about y, (..., 4)."""
    half, zero = (np.pi / 2 - a) / 2, np.zeros_like(a)
    return np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1)


def load(a: float, rate: float, friction: float) -> tuple[float, float]:
    """A, with the rounded foot's radius in the arm of friction, and the load N on the foot [N], at the angle a and a'."""
    arm = HALF * np.cos(a)
    coefficient = 1 + MASS * arm / INERTIA * (arm - friction * (HALF * np.sin(a) + RADIUS))
    return float(coefficient), float(MASS * (G - HALF * rate**2 * np.sin(a)) / coefficient)


def acceleration(q: Floats, rate: Floats, friction: float) -> Floats:
    """x'' and a'' of a rod whose foot slides towards -x: m x'' = mu N, I a'' = N (mu (l sin a + r) - l cos a)."""
    normal = load(float(q[1]), float(rate[1]), friction)[1]
    turning = friction * (HALF * np.sin(q[1]) + RADIUS) - HALF * np.cos(q[1])
    return normal * np.array([friction / MASS, turning / INERTIA])


def placed(time: Floats, y: Floats) -> Trajectory:
    """The rod at x, a, x', a' (t, 4) with its foot on the ground."""
    made = Trajectory.of(time, 2)
    x, a, speed, rate = y.T
    made.p_WB[:, 1, 0], made.p_WB[:, 1, 2] = x, RADIUS + HALF * np.sin(a)
    made.v_WB[:, 1, 0], made.v_WB[:, 1, 2] = speed, HALF * rate * np.cos(a)
    made.q_WB[:, 1], made.w_WB[:, 1, 1] = _attitude(a), -rate
    return made


def _slides_on(y: Floats, friction: float) -> bool:
    """Does the foot slide towards -x, on the ground and pushed by it, at each of the states (t, 4)?"""
    _, a, speed, rate = y.T
    foot = speed + (HALF * np.sin(a) + RADIUS) * rate
    loads = [load(float(angle), float(turning), friction) for angle, turning in zip(a, rate, strict=True)]
    return bool(np.all(foot < 0)) and all(coefficient > 0 and normal > 0 for coefficient, normal in loads)


def expected(time: Floats, p: P) -> Converged | None:
    """The sliding rod, integrated at a relative tolerance of 1e-12 with the distance to 1e-10 as its error bar; None where it
    does not slide to the end: in the paradox, and where its foot stops or lifts off."""
    start, still = [0.0, float(np.radians(p.angle))], [-p.speed, 0.0]
    if load(start[1], 0.0, p.friction)[0] <= 0:
        return None
    try:
        fine, coarse = (
            true_motion(lambda q, v: acceleration(q, v, p.friction), start, still, time, rtol) for rtol in (1e-12, 1e-10)
        )
    except RuntimeError:
        return None
    if not _slides_on(fine, p.friction):
        return None
    truth, other = placed(time, fine), placed(time, coarse)
    return Converged.between(truth, other)


@lru_cache(maxsize=16)
def _first_order(p: P) -> tuple[float, float]:
    """Largest errors per dt of position [m/s] and velocity [m/s2]; NaN where there is no motion to err from."""
    times, small = np.linspace(0.0, DURATION, 101), 1e-6
    start, still = [0.0, float(np.radians(p.angle))], [-p.speed, 0.0]
    if expected(times, p) is None:
        return float("nan"), float("nan")
    true = placed(times, true_motion(lambda q, v: acceleration(q, v, p.friction), start, still, times, 1e-12))
    moved = turned = 0.0
    for y in first_order_motions(lambda q, v: acceleration(q, v, p.friction), start, still, times, small):
        other = placed(times, y)
        moved = max(moved, float(np.linalg.norm(other.p_WB - true.p_WB, axis=-1).max()) / small)
        turned = max(turned, float(np.linalg.norm(other.v_WB - true.v_WB, axis=-1).max()) / small)
    return moved, turned


CASE = Case.of(
    globals(),
    title="Painleve's rod",
    question="Does a rod that slides foot first follow Coulomb's law as long as that has a solution, and stay finite beyond?",
    source="Painleve, C. R. Acad. Sci. 121 (1895) 112; Genot, Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653",
    truth="converged reference",
    # Every step: the impulse of a blow lies in one of them.
    sample_interval=0.0,
    dt=1 / 960,
    ladder=(1 / 240, 1 / 480, 1 / 960, 1 / 1920, 1 / 3840, 1 / 7680),
    hard=Axis(parameter="friction", unit="1", easy=0.5, extreme=3.0),
    checks=(
        Check(errors.position_error_max, lambda dt, p: 2 * _first_order(p)[0] * dt, FIRST_ORDER),
        Check(
            contacts.impulse_max,
            lambda dt, p: 2 * MASS * float(np.sqrt(p.speed**2 + 2 * G * HALF)) + MASS * G * dt.outer,
            "an impulse is the change of momentum less that by weight, and without energy from nowhere the centre is "
            "never faster than v^2 = v0^2 + 2 g l: m times twice that speed, and m g dt. A law that is solved for forces where "
            "it has none has no bound at all",
        ),
        Check(
            conservation.energy_gain_max,
            1e-6,
            "friction takes 200 W from the first step on, and nothing gives; 1e-6 for single precision",
        ),
        forces_keep_momentum(),
        *forces_obey_coulomb(),
    ),
    observe=(slide.painleve_coefficient, errors.velocity_error_max, errors.position_error_final),
)
