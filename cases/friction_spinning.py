"""A stool spun about its own axis on the ground: how long until its feet have rubbed the spin away?

Feet at the distance rho from the axis share the weight evenly, so that the moment is mu m g rho and the spin ends after
t = w I/(mu m g rho). A disc with uniform pressure has 2/3 of its radius for rho: t = 3 w R/(4 mu g) for I = m R^2/2. The stool
has feet and no face, so that no engine's choice of contact points decides.
"""

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, forces_obey_coulomb
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Effect, PlacedShape, Scene, Sphere, Surface, cylinder_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import about

DURATION = 1.5
SPIN, MASS = 10.0, 1.0
FOOT, OUT, LOW = 0.02, 0.2, 0.05
"""Radius of a foot, its distance from the axis, and its centre's depth below the centre of mass [m]."""
INERTIA = cylinder_inertia(MASS, 0.2, 0.03)


class P(Parameters):
    spin: float = SPIN
    friction: NotNegative = 0.3


def scene(p: P) -> Scene:
    """A stool of four round feet on the ground, spinning at `spin` [rad/s] about the vertical."""
    feet = tuple(PlacedShape(shape=Sphere(radius=FOOT), p_BS=(x, y, -LOW)) for x in (-OUT, OUT) for y in (0.0,)) + tuple(
        PlacedShape(shape=Sphere(radius=FOOT), p_BS=(0.0, y, -LOW)) for y in (-OUT, OUT)
    )
    stool = Body(
        name="stool",
        mass=MASS,
        inertia=INERTIA,
        collision=feet,
        material="stool",
        p_WB=(0.0, 0.0, LOW + FOOT),
        w_WB=(0.0, 0.0, p.spin),
    )
    return Scene(
        bodies=(Body.ground(), stool),
        surfaces=(Surface.rough(p.friction, ("stool", "ground")),),
        narrow=Effect.GYROSCOPIC,
    )


def deceleration(friction: float) -> float:
    """mu m g rho/I [rad/s2]."""
    return friction * MASS * G * OUT / INERTIA[2][2]


def expected(time: Floats, p: P) -> Trajectory:
    """Uniform deceleration of the spin, then rest."""
    truth = Trajectory.at_rest(scene(p), time)
    a = deceleration(p.friction)
    t = truth.time if a == 0 else np.minimum(truth.time, abs(p.spin) / a)
    angle = np.sign(p.spin) * (abs(p.spin) * t - a * t**2 / 2)
    truth.q_WB[:, 1] = about(2, angle)
    truth.w_WB[:, 1, 2] = np.sign(p.spin) * (abs(p.spin) - a * t)
    return truth


def _rate(dt: float, p: P) -> float:
    """A first step without a contact, and a last one rubbed through to its end."""
    return 2 * deceleration(p.friction) * dt


CASE = Case.of(
    globals(),
    title="Spinning stool",
    question="Do feet that slide in a circle brake a spin as Coulomb's law says?",
    source="Farkas, Bartels, Unger, Wolf, Frictional coupling between sliding and spinning motion, Phys. Rev. Lett. 90 (2003) "
    "248302, for the disc; four feet by hand",
    truth="closed form",
    converges="once",
    scale=SPIN,
    checks=(
        Check(
            errors.angular_velocity_error_max,
            _rate,
            "a first step without a contact and a last one rubbed through to its end: mu m g rho dt/I each",
        ),
        Check(
            errors.attitude_error_max,
            lambda dt, p: _rate(dt, p) * DURATION + abs(p.spin) * dt,
            "the error of the spin all the way, and a staggered scheme's half step of turning, taken twice",
        ),
        Check(
            errors.position_error_max,
            lambda dt, _: 2 * G * dt**2 + GIVE,
            "the feet's forces along the ground cancel; a first step of free fall, and a millimetre for contacts that give way",
        ),
        Check(
            errors.angular_velocity_error_final,
            lambda dt, p: deceleration(p.friction) * dt,
            "at rest friction takes any spin that is less than it can take in a step",
        ),
        *forces_obey_coulomb(),
    ),
)
