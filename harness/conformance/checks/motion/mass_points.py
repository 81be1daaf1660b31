"""Checks of mass points: bodies without inertia fly, hang on springs, and count where they are fixed."""

from math import cos, sin, sqrt

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Adapter, Feature, Settings
from plumbline.harness.conformance.check import CheckResult, check, judge, near
from plumbline.harness.conformance.room import FINE, final
from plumbline.harness.conformance.scenes import G, angle_between, free
from plumbline.harness.scene import (
    WORLD,
    Body,
    Distance,
    Fixed,
    Revolute,
    Scene,
    Spring,
    Vector3,
    axis_angle,
    principal_inertia,
)

_ORIGIN: Vector3 = (0.0, 0.0, 0.0)
_Y: Vector3 = (0.0, 1.0, 0.0)
_HALF_A_STEP = 5e-3
"""A staggered scheme of first order is off by v dt/2, at most 2.5 mm at 5 m/s and 1 ms."""


def _point(name: str, p: Vector3, mass: float = 0.5, v: Vector3 = _ORIGIN, w: Vector3 = _ORIGIN) -> Body:
    return Body(name=name, mass=mass, inertia=principal_inertia(0.0, 0.0, 0.0), p_WB=p, v_WB=v, w_WB=w)


@check(
    "Does a body without inertia move as its mass says, free and on a spring, without turning?",
    Feature.MASS_POINT | Feature.DISTANCE_SPRING,
)
def mass_point_flies_and_hangs(adapter: Adapter, settings: Settings) -> CheckResult:
    """One is thrown, p = v t + g t^2/2; one hangs on a spring, z = -l - (m g/k)(1 - cos(t sqrt(k/m))), and turns nowhere."""
    t, k, m = 0.4, 80.0, 0.5
    thrown, hung = _point("thrown", _ORIGIN, v=(1.0, 2.0, 3.0)), _point("hung", (5.0, 0.0, -1.0), m)
    spring = Distance(
        name="spring",
        parent=WORLD,
        child="hung",
        anchor_W=(5.0, 0.0, 0.0),
        child_anchor_W=hung.p_WB,
        spring=Spring(stiffness=k, rest=1.0),
    )
    end = final(adapter, Scene(bodies=(thrown, hung), joints=(spring,)), settings.with_dt(FINE), t)
    depth = m * G / k * (1 - cos(t * sqrt(k / m)))
    return judge(
        near("place of a thrown point [m]", end.p_WB[0], (t, 2 * t, 3 * t - G * t * t / 2), _HALF_A_STEP, "half a step of g t"),
        near("place of one on a spring [m]", end.p_WB[1], (5.0, 0.0, -1.0 - depth), _HALF_A_STEP, "half a step of motion"),
        near("their turns [rad]", [angle_between(q, (1.0, 0.0, 0.0, 0.0)) for q in end.q_WB], (0.0, 0.0), 1e-9, "no torque"),
    )


@check(
    "Does a mass point that is fixed to a body add its mass there, and no inertia of its own?",
    Feature.MASS_POINT | Feature.FIXED | Feature.REVOLUTE,
)
def mass_point_counts_where_it_is_fixed(adapter: Adapter, settings: Settings) -> CheckResult:
    """(I + m d^2 + M r^2) a'' = -(m d + M r) g sin a of a rod with a point M on its lower end, r from its pin."""
    t, rod, moment, d, point, r = 0.9, 2.0, 0.2, 0.5, 1.5, 1.2
    inertia, weight = moment + rod * d * d + point * r * r, (rod * d + point * r) * G
    swing = solve_ivp(lambda _, y: (y[1], -weight * sin(y[0]) / inertia), (0, t), (1.0, 0.0), rtol=1e-10, atol=1e-10)
    angle, rate = swing.y[:, -1]

    def below(distance: float, a: float) -> Vector3:
        return (-distance * sin(a), 0.0, -distance * cos(a))

    body = free("rod", mass=rod, moments=(moment,) * 3, p=below(d, 1.0), q=axis_angle(_Y, 1.0))
    joints = (
        Revolute(name="pin", parent=WORLD, child="rod", anchor_W=_ORIGIN, axis_W=_Y),
        Fixed(name="weld", parent="rod", child="point"),
    )
    scene = Scene(bodies=(body, _point("point", below(r, 1.0), point)), joints=joints)
    end = final(adapter, scene, settings.with_dt(FINE), t)
    return judge(
        near("the rod [m]", end.p_WB[0], below(d, angle), _HALF_A_STEP, "half a step of motion, and default damping"),
        near("the point [m]", end.p_WB[1], below(r, angle), 2 * _HALF_A_STEP, "half a step of motion, and default damping"),
        near("the rod's rate [rad/s]", end.w_WB[0], np.array([0.0, rate, 0.0]), 0.04, "a step of its acceleration"),
    )
