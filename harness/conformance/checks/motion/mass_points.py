"""Checks of mass points: bodies without inertia fly, hang on springs, and count where they are fixed."""

from math import cos, sqrt

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, near
from plumbline.harness.conformance.closed_forms import pendulum_end, swing
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.conformance.frames import ORIGIN, UPRIGHT, Y, aligned
from plumbline.harness.conformance.scenes import G, free, revolute, tie
from plumbline.harness.scene import Body, Fixed, Scene, Spring, Vector3, axis_angle, principal_inertia

_HALF_A_STEP = 5e-3
"""A staggered scheme of first order is off by v dt/2, at most 2.5 mm at 5 m/s and 1 ms."""


def _point(name: str, p: Vector3, mass: float = 0.5, v: Vector3 = ORIGIN, w: Vector3 = ORIGIN) -> Body:
    return Body(name=name, mass=mass, inertia=principal_inertia(0.0, 0.0, 0.0), p_WB=p, v_WB=v, w_WB=w)


@check(
    "Does a body without inertia move as its mass says, free and on a spring, without turning?",
    Feature.MASS_POINT | Feature.DISTANCE_SPRING,
)
def mass_point_flies_and_hangs(engine: Engine) -> Comparisons:
    """One is thrown, p = v t + g t^2/2; one hangs on a spring, z = -l - (m g/k)(1 - cos(t sqrt(k/m))), and turns nowhere."""
    t, k, m = 0.4, 80.0, 0.5
    thrown, hung = _point("thrown", ORIGIN, v=(1.0, 2.0, 3.0)), _point("hung", (5.0, 0.0, -1.0), m)
    spring = tie("spring", "hung", (5.0, 0.0, 0.0), hung.p_WB, spring=Spring(stiffness=k, rest=1.0))
    end = engine.final(Scene(bodies=(thrown, hung), joints=(spring,)), t)
    depth = m * G / k * (1 - cos(t * sqrt(k / m)))
    flown = (t, 2 * t, 3 * t - G * t * t / 2)
    yield near("place of a thrown point [m]", end.p_WB[0], flown, _HALF_A_STEP, "half a step of g t")
    yield near("place of one on a spring [m]", end.p_WB[1], (5.0, 0.0, -1.0 - depth), _HALF_A_STEP, "half a step of motion")
    yield aligned("their turns [rad]", end.q_WB, [UPRIGHT] * 2, 1e-9, "no torque")


@check(
    "Does a mass point that is fixed to a body add its mass there, and no inertia of its own?",
    Feature.MASS_POINT | Feature.FIXED | Feature.REVOLUTE,
)
def mass_point_counts_where_it_is_fixed(engine: Engine) -> Comparisons:
    """(I + m d^2 + M r^2) a'' = -(m d + M r) g sin a of a rod with a point M on its lower end, r from its pin."""
    t, rod, moment, d, point, r = 0.9, 2.0, 0.2, 0.5, 1.5, 1.2
    inertia, weight = moment + rod * d * d + point * r * r, (rod * d + point * r) * G
    angle, rate = swing(weight, inertia, t)
    body = free("rod", mass=rod, moments=(moment,) * 3, p=pendulum_end(d, 1.0), q=axis_angle(Y, 1.0))
    joints = (revolute("pin", "rod", ORIGIN, Y), Fixed(name="weld", parent="rod", child="point"))
    scene = Scene(bodies=(body, _point("point", pendulum_end(r, 1.0), point)), joints=joints)
    end = engine.final(scene, t)
    yield near("the rod [m]", end.p_WB[0], pendulum_end(d, angle), _HALF_A_STEP, "half a step of motion, and default damping")
    yield near(
        "the point [m]", end.p_WB[1], pendulum_end(r, angle), 2 * _HALF_A_STEP, "half a step of motion, and default damping"
    )
    yield near("the rod's rate [rad/s]", end.w_WB[0], np.array([0.0, rate, 0.0]), 0.04, "a step of its acceleration")
