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
AGREES = 1e-6
"""Rates below this share of the speeds that they are made of are none: a scene in single precision is off by half an ulp, 6e-8,
in each of the at most ten numbers and products that a component of a rate sums."""


def check_slenderness(bodies: Sequence[Body], joints: Sequence[Joint]) -> None:
    """Raises: NotSupported naming the first body, held by a joint, whose principal moments are further apart."""
    held = {name for joint in joints for name in (joint.parent, joint.child)}
    for body in bodies:
        if body.motion == "dynamic" and body.name in held:
            least, _, most = eigenvalues(np.asarray(body.inertia, float)).tolist()
            if least * SLENDEREST < most:
                raise NotSupported(
                    f"joints on body '{body.name}'",
                    f"its principal moments of inertia go from {least:.3g} to {most:.3g} kg m2, expected at "
                    f"most {SLENDEREST:.0e} times as much",
                )


def check_initial_rates(bodies: Sequence[Body], joints: Sequence[Joint]) -> None:
    """Raises: NotSupported naming the first joint that the initial velocities would open, and how fast; or the first coupling.

    Terms: bodies whose names the joints know, checked before.
    """
    named = {body.name: body for body in bodies}
    scalar = {joint.name: joint for joint in joints if isinstance(joint, Revolute | Prismatic)}
    for joint in joints:
        for rate, speed, unit_of in _forbidden(named, joint):
            if rate > AGREES * speed:
                raise NotSupported(
                    f"joint '{joint.name}'",
                    f"the initial velocities of '{joint.parent}' and '{joint.child}' break it by {rate:.3g} {unit_of}, "
                    "expected velocities that the joint allows",
                )
    for follower in scalar.values():
        if follower.coupling is None:
            continue
        ratio = follower.coupling.ratio
        (rate, speed), (other, other_speed) = (
            coordinate_rate(named, end) for end in (follower, scalar[follower.coupling.joint])
        )
        if abs(rate - ratio * other) > AGREES * (speed + abs(ratio) * other_speed):
            raise NotSupported(
                f"joint '{follower.name}'",
                f"its initial rate is {rate:.3g}, expected {ratio * other:.3g} by its coupling to '{follower.coupling.joint}'",
            )


def coordinate_rate(named: Mapping[str, Body], joint: Revolute | Prismatic) -> tuple[float, float]:
    """The initial rate of a joint's coordinate [rad/s or m/s], and the sum of the speeds that make it.

    Args: named: all bodies by their names; others are the world.
    """
    axis, anchor = unit(np.asarray(joint.axis_W, float)), np.asarray(joint.anchor_W, float)
    dv, dw, fast, spin = _motion(named, joint, anchor, anchor)
    return (float(dot(axis, dw)), spin) if isinstance(joint, Revolute) else (float(dot(axis, dv)), fast)


def _forbidden(named: Mapping[str, Body], joint: Joint) -> list[tuple[float, float, str]]:
    """How much of the relative velocities at its anchors a joint forbids, the sum of the speeds that make it, and the unit."""
    fixed_on = named[joint.child if joint.child in named else joint.parent]
    anchor_a = np.asarray(fixed_on.p_WB if isinstance(joint, Fixed) else joint.anchor_W, float)
    anchor_b = np.asarray(joint.child_anchor_W, float) if isinstance(joint, Distance) else anchor_a
    dv, dw, fast, spin = _motion(named, joint, anchor_a, anchor_b)
    if isinstance(joint, Distance):
        way = anchor_b - anchor_a
        kept = joint.limits is None and joint.spring is None
        return [(abs(float(dot(way, dv))) / float(norm(way)), fast, "m/s")] if kept else []
    if isinstance(joint, Revolute | Prismatic):
        axis = unit(np.asarray(joint.axis_W, float))
        dv, dw = (np.cross(axis, dv), dw) if isinstance(joint, Prismatic) else (dv, np.cross(axis, dw))
    sliding, turning = (float(norm(dv)), fast, "m/s"), (float(norm(dw)), spin, "rad/s")
    return [sliding] if isinstance(joint, Ball) else [sliding, turning]


def _motion(named: Mapping[str, Body], joint: Joint, anchor_a: Floats, anchor_b: Floats) -> tuple[Floats, Floats, float, float]:
    """Velocity and angular velocity of the child at its anchor against the parent at its own, and the sums of the speeds that
    make either."""
    v, w, speeds = [np.zeros(3)] * 2, [np.zeros(3)] * 2, [0.0, 0.0]
    for k, (name, anchor) in enumerate(((joint.parent, anchor_a), (joint.child, anchor_b))):
        if name in named and named[name].motion != "static":
            body = named[name]
            w[k], arm = np.asarray(body.w_WB, float), anchor - np.asarray(body.p_WB, float)
            v[k] = np.asarray(body.v_WB, float) + np.cross(w[k], arm)
            speeds[0] += float(norm(np.asarray(body.v_WB, float)) + norm(w[k]) * norm(arm))
            speeds[1] += float(norm(w[k]))
    return v[1] - v[0], w[1] - w[0], speeds[0], speeds[1]
