"""Checks of fixed tendons: a force along the length acts on each joint by its arm, and on no other."""

from math import cos, exp, sin, sqrt

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, near
from plumbline.harness.conformance.engine import FINE, Engine
from plumbline.harness.conformance.frames import X, Y
from plumbline.harness.conformance.scenes import free, prismatic, revolute, without_gravity
from plumbline.harness.scene import Drive, Limits, MomentArm, Scene, Spring, Tendon
from plumbline.harness.trajectory import Floats

_MASSES = (2.0, 3.0)
_MOMENT = 0.3
_ARMS = (1.0, -2.0, 0.5)
"""Of two slides along x and of a wheel about y [1, 1, m/rad]."""
_HALF_A_STEP = 0.5 * FINE
"""A staggered scheme of first order is off by half a step of motion; no rate here comes to 1 m/s or 1 rad/s."""
_GIVE = 1e-3
"""What a stop that is a stiff spring may give way under 1 N [m]: as much as a contact may under weight."""


def _pulled(*positions: float, **laws: Spring | Drive | Limits) -> Scene:
    """Two slides, a wheel and, beside them, a slide that no tendon is on; one tendon with these laws, without gravity."""
    bodies = (
        free("first", mass=_MASSES[0]),
        free("second", mass=_MASSES[1], p=(0.0, 3.0, 0.0)),
        free("wheel", p=(0.0, 6.0, 0.0), moments=(_MOMENT,) * 3),
        free("beside", p=(0.0, 9.0, 0.0)),
    )
    kinds = ((prismatic, X), (prismatic, X), (revolute, Y), (prismatic, X))
    joints = tuple(
        kind(f"to {b.name}", b.name, b.p_WB, axis, position=position)
        for (kind, axis), b, position in zip(kinds, bodies, (*positions, *(0.0,) * (4 - len(positions))), strict=True)
    )
    arms = tuple(MomentArm(joint=joint.name, arm=arm) for joint, arm in zip(joints, _ARMS, strict=False))
    tendons = (Tendon(name="tendon", arms=arms, **laws),)  # type: ignore[arg-type]
    return without_gravity(*bodies, joints=joints, tendons=tendons)


_ANSWER = _ARMS[0] ** 2 / _MASSES[0] + _ARMS[1] ** 2 / _MASSES[1] + _ARMS[2] ** 2 / _MOMENT
"""The acceleration of the length by a unit force along it [1/kg]: sum of arm^2/inertia."""


def _moved(stretch: float) -> tuple[float, float, float]:
    """Where the slides go [m] and the wheel turns to [rad] while the length grows by `stretch` [m], from rest."""
    first, second, turned = (arm / inertia * stretch / _ANSWER for arm, inertia in zip(_ARMS, (*_MASSES, _MOMENT), strict=True))
    return first, second, turned


def _turn_about_y(q: Floats) -> float:
    """The angle [rad] within half a turn; q and -q are the same one."""
    return 2 * float(np.arctan(q[2] / q[0]))


@check(
    "Does the spring of a tendon pull at each joint by its arm, and at no other?",
    Feature.PRISMATIC | Feature.REVOLUTE | Feature.TENDON,
)
def tendon_spring_pulls_by_its_arms(engine: Engine) -> Comparisons:
    """l'' = -s (k (l - r) + c l') with s = sum arm^2/inertia, from where the coordinates stand at the start."""
    k, c, rest, t = 4.0, 0.6, 0.5, 0.8
    start = (0.2, -0.3, 0.4)
    stretch = float(np.dot(_ARMS, start)) - rest
    end = engine.final(_pulled(*start, spring=Spring(stiffness=k, damping=c, rest=rest)), t)
    decay, square = _ANSWER * c / 2, _ANSWER * k
    omega = sqrt(square - decay**2)
    left = stretch * exp(-decay * t) * (cos(omega * t) + decay / omega * sin(omega * t))
    first, second, turned = _moved(left - stretch)
    wheel = _turn_about_y(end.q_WB[2])
    yield near("ways of two slides [m]", end.p_WB[:2, 0], (first, second), _HALF_A_STEP, "half a step of motion")
    yield near("turn of a wheel [rad]", wheel, turned, _HALF_A_STEP, "half a step of motion")
    yield near("way of a slide beside them [m]", end.p_WB[3, 0], 0.0, 1e-9, "nothing pulls at it")


@check(
    "Is the drive of a tendon cut off at its limit, and its length stopped at its bound?",
    Feature.PRISMATIC | Feature.REVOLUTE | Feature.TENDON | Feature.DRIVES,
)
def tendon_drive_and_limits_hold(engine: Engine) -> Comparisons:
    """A drive of 50 N/m a long way off pulls with its limit f: l = s f t^2/2; under a motor a tendon rests at its bound."""
    force, t, bound = 0.4, 0.5, 0.1
    pulled = _pulled(drive=Drive(stiffness=50.0, target=5.0, limit=force))
    ways = engine.final(pulled, t).p_WB[:2, 0]
    first, second, _ = _moved(_ANSWER * force * t * t / 2)
    stopped = _pulled(drive=Drive(damping=5.0, target_velocity=0.2), limits=Limits(upper=bound))
    end = engine.final(stopped, 3.0)
    wheel = _turn_about_y(end.q_WB[2])
    length = float(np.dot(_ARMS, (*end.p_WB[:2, 0], wheel)))
    yield near("ways under the limit of a drive [m]", ways, (first, second), _HALF_A_STEP, "half a step of motion")
    yield near("length at its bound [m]", length, bound, _GIVE, "a motor of 1 N against a stop that may be soft")
