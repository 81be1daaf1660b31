"""Whether the joints of a world fit its bodies: velocities at the start that joints and couplings allow, and moments of inertia
near enough to each other for their inverse in floats."""

from collections.abc import Mapping, Sequence

import numpy as np

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import Ball, Distance, Fixed, Joint, Prismatic, Revolute
from plumbline.engine.maths.arrays import dot, eigenvalues, norm, unit
from plumbline.engine.maths.types import Floats

SLENDEREST = 1e10
"""The largest ratio of a body's principal moments. In the world's axes each entry of the inverse inertia is rounded to 1e-16 of
the largest, about the thin axis: a rod of 1e10 (4 micrometres thick, a metre long) has six digits left across it, one of 1e14
none that SHAKE can use."""


def check_slenderness(bodies: Sequence[Body], joints: Sequence[Joint]) -> None:
    """Raises: NotSupported naming the first body, held by a joint, whose principal moments are further apart."""
    held = {name for joint in joints for name in (joint.parent, joint.child)}
    movable = [body for body in bodies if body.motion == "dynamic" and body.name in held]
    if not movable:
        return
    moments = np.array([eigenvalues(np.asarray(body.inertia, float)) for body in movable])
    slender = moments[:, 0] * SLENDEREST < moments[:, 2]
    if slender.any():
        k = int(slender.argmax())
        raise NotSupported(
            f"joints on body '{movable[k].name}'",
            f"its principal moments of inertia go from {moments[k, 0]:.3g} to {moments[k, 2]:.3g} kg m2, expected at "
            f"most {SLENDEREST:.0e} times as much",
        )


AGREES = 1e-6
"""Rates below this share of the speeds that they are made of are none: a scene in single precision is off by half an ulp, 6e-8,
in each of the at most ten numbers and products that a component of a rate sums."""


def check_initial_rates(bodies: Sequence[Body], joints: Sequence[Joint]) -> None:
    """Raises: NotSupported naming the first joint that the initial velocities would open, and how fast.

    Terms: bodies whose names the joints know, checked before.
    """
    known = {body.name: body for body in bodies}
    for joint in joints:
        a, b = known.get(joint.parent), known.get(joint.child)
        end_b = b if b is not None else a
        assert end_b is not None
        anchor_a = np.asarray(end_b.p_WB if isinstance(joint, Fixed) else joint.anchor_W, float)
        anchor_b = np.asarray(joint.child_anchor_W, float) if isinstance(joint, Distance) else anchor_a
        (v_a, w_a, fast_a), (v_b, w_b, fast_b) = _motion(a, anchor_a), _motion(b, anchor_b)
        sliding, turning = _forbidden(joint, v_b - v_a, w_b - w_a, anchor_b - anchor_a)
        spin = float(norm(w_a) + norm(w_b))
        for rate, speed, measure in ((sliding, fast_a + fast_b, "m/s"), (turning, spin, "rad/s")):
            if rate > AGREES * speed:
                raise NotSupported(
                    f"joint '{joint.name}'",
                    f"the initial velocities of '{joint.parent}' and '{joint.child}' break it by {rate:.3g} {measure}, "
                    "expected velocities that the joint allows",
                )
    _check_coupled_rates(known, joints)


def _check_coupled_rates(named: Mapping[str, Body], joints: Sequence[Joint]) -> None:
    """Raises: NotSupported naming the first coupling that the initial velocities break, and by how much."""
    scalar = {joint.name: joint for joint in joints if isinstance(joint, Revolute | Prismatic)}
    for joint in scalar.values():
        if joint.coupling is None:
            continue
        (rate, speed), (other, other_speed) = (_rate(named, end) for end in (joint, scalar[joint.coupling.joint]))
        ratio = joint.coupling.ratio
        if abs(rate - ratio * other) > AGREES * (speed + abs(ratio) * other_speed):
            raise NotSupported(
                f"joint '{joint.name}'",
                f"its initial rate is {rate:.3g}, expected {ratio * other:.3g} by its coupling to '{joint.coupling.joint}'",
            )


def _rate(named: Mapping[str, Body], joint: Revolute | Prismatic) -> tuple[float, float]:
    """The initial rate of a joint's coordinate [rad/s or m/s], and the sum of the speeds that make it."""
    axis, anchor = unit(np.asarray(joint.axis_W, float)), np.asarray(joint.anchor_W, float)
    (v_a, w_a, fast_a), (v_b, w_b, fast_b) = (_motion(named.get(name), anchor) for name in (joint.parent, joint.child))
    if isinstance(joint, Revolute):
        return float(dot(axis, w_b - w_a)), float(norm(w_a) + norm(w_b))
    return float(dot(axis, v_b - v_a)), fast_a + fast_b


def _motion(body: Body | None, anchor: Floats) -> tuple[Floats, Floats, float]:
    """The velocity of the body's point at the anchor, its angular velocity, and the sum of the speeds that make the first."""
    if body is None or body.motion == "static":
        return np.zeros(3), np.zeros(3), 0.0
    v, w, arm = np.asarray(body.v_WB, float), np.asarray(body.w_WB, float), anchor - np.asarray(body.p_WB, float)
    return v + np.cross(w, arm), w, float(norm(v) + norm(w) * norm(arm))


def _forbidden(joint: Joint, dv: Floats, dw: Floats, way: Floats) -> tuple[float, float]:
    """How much of the relative velocity [m/s] and angular velocity [rad/s] at the anchors the joint forbids."""
    if isinstance(joint, Distance):
        kept = joint.limits is None and joint.spring is None
        return (abs(float(dot(way, dv))) / float(norm(way)) if kept else 0.0), 0.0
    if isinstance(joint, Ball):
        return float(norm(dv)), 0.0
    if isinstance(joint, Fixed):
        return float(norm(dv)), float(norm(dw))
    axis = unit(np.asarray(joint.axis_W, float))
    if isinstance(joint, Revolute):
        return float(norm(dv)), float(norm(np.cross(axis, dw)))
    return float(norm(np.cross(axis, dv))), float(norm(dw))
