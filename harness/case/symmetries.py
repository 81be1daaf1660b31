"""The same scene told another way: at another place, turned, in motion, at another size, in another order.

Newton's laws do not tell these apart, so that each retelling, told back in the words of the first, must give the same motion:
bit for bit where nothing but the run is another one, else to the rounding that the other numbers bring.

Source: Barenblatt, Scaling (2003), chapter 1 (dimensional analysis); Landau, Lifshitz, Mechanics, 3rd ed., sections 3 and 10.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.case.forces import Control
from plumbline.harness.scene import WORLD, Body, Joint, Prescribed, Quaternion, Scene, Vector3
from plumbline.harness.scene import multiply as times
from plumbline.harness.scene import rotate as turned_vector
from plumbline.harness.scene.shape import scaled_shape
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.kinematics import conjugate, product, rotate


@dataclass(frozen=True, slots=True, kw_only=True)
class Retelling:
    """A scene that means the same as a case's own.

    Terms:
        name: under which its motion stands beside the case's. back: its trajectory in the words of the case's scene.
        clock: by what the time of the case, its step too, is multiplied. restored_at [s]: there the state is saved, and after
        the run's end it is taken back to that; None for a plain run. control: what acts on it from outside, as on the case's.
    """

    name: str
    scene: Scene
    back: Callable[[Trajectory], Trajectory]
    clock: float = 1.0
    restored_at: float | None = None
    control: Control | None = None


def _same(trajectory: Trajectory) -> Trajectory:
    return trajectory


def repeated(scene: Scene) -> Retelling:
    """The very same scene once more."""
    return Retelling(name="repeated", scene=scene, back=_same)


def restored(scene: Scene, time: float) -> Retelling:
    """The very same scene, taken back from its end to what was saved at `time` [s]."""
    return Retelling(name="restored", scene=scene, back=_same, restored_at=time)


def nudged(scene: Scene) -> Retelling:
    """The very same scene, but for the last bit of the x of the first body that can move."""
    place = next(k for k, body in enumerate(scene.bodies) if body.movable)
    body = scene.bodies[place]
    x, y, z = body.p_WB
    other = replace(body, p_WB=(float(np.nextafter(x, np.inf)), y, z))
    bodies = (*scene.bodies[:place], other, *scene.bodies[place + 1 :])
    return Retelling(name="nudged", scene=replace(scene, bodies=bodies), back=_same)


BUILT = 1e-9
"""Metres by which starts differ that nobody could tell apart: ten atoms."""
STARTS = 8
"""Of a question whose answer hangs on bits, the case's own among them."""


def started(scene: Scene, number: int, control: Control | None = None) -> Retelling:
    """The same scene from a start of its own, which that number draws: each free body up to `BUILT` off its place."""
    joined = {name for joint in scene.joints for name in (joint.parent, joint.child)}
    draw = np.random.default_rng(number)
    bodies = [
        replace(body, p_WB=tuple((np.array(body.p_WB) + draw.uniform(-BUILT, BUILT, 3)).tolist()))
        if body.movable and body.name not in joined
        else body
        for body in scene.bodies
    ]
    return Retelling(name=f"start_{number}", scene=replace(scene, bodies=tuple(bodies)), back=_same, control=control)


def other_starts(scene: Scene, control: Control | None = None) -> tuple[Retelling, ...]:
    """Seven other starts that nobody could tell from the first."""
    return tuple(started(scene, number, control) for number in range(1, STARTS))


def reordered(scene: Scene) -> Retelling:
    """Bodies and joints from the last to the first."""
    other = replace(scene, bodies=scene.bodies[::-1], joints=scene.joints[::-1])

    def back(run: Trajectory) -> Trajectory:
        return replace(run, p_WB=run.p_WB[:, ::-1], q_WB=run.q_WB[:, ::-1], v_WB=run.v_WB[:, ::-1], w_WB=run.w_WB[:, ::-1])

    return Retelling(name="reordered", scene=other, back=back)


def moved(scene: Scene, by: Vector3) -> Retelling:
    """Everything `by` [m] away."""
    bodies = tuple(
        replace(body, p_WB=_sum(body.p_WB, by), prescribed=_led(body.prescribed, lambda point: _sum(point, by)))
        for body in scene.bodies
    )
    joints = tuple(_anchored(joint, lambda point: _sum(point, by)) for joint in scene.joints)

    def back(run: Trajectory) -> Trajectory:
        return replace(run, p_WB=run.p_WB - np.array(by))

    return Retelling(name="moved", scene=replace(scene, bodies=bodies, joints=joints), back=back)


def turned(scene: Scene, q: Quaternion) -> Retelling:
    """Everything, gravity too, turned about the origin."""

    def at(vector: Vector3) -> Vector3:
        return turned_vector(q, vector)

    bodies = tuple(
        replace(
            body,
            p_WB=at(body.p_WB),
            q_WB=times(q, body.q_WB),
            v_WB=at(body.v_WB),
            w_WB=at(body.w_WB),
            prescribed=_led(body.prescribed, at, at),
        )
        for body in scene.bodies
    )
    joints = tuple(_anchored(joint, at, at) for joint in scene.joints)

    def back(run: Trajectory) -> Trajectory:
        home = conjugate(np.array(q))
        p_WB, v_WB, w_WB = (rotate(home, vectors) for vectors in (run.p_WB, run.v_WB, run.w_WB))
        return replace(run, p_WB=p_WB, q_WB=product(home, run.q_WB), v_WB=v_WB, w_WB=w_WB)

    return Retelling(name="turned", scene=replace(scene, bodies=bodies, joints=joints, gravity=at(scene.gravity)), back=back)


def in_motion(scene: Scene, velocity: Vector3) -> Retelling:
    """Everything in uniform motion; what stood still becomes kinematic. Raises: ValueError for a joint to the world."""
    for joint in scene.joints:
        if joint.parent == WORLD:
            raise ValueError(f"joint '{joint.name}': holds to the world, which cannot move; expected a static body")
    bodies = tuple(
        replace(body, v_WB=_sum(body.v_WB, velocity), motion="kinematic" if body.motion == "static" else body.motion)
        for body in scene.bodies
    )

    def back(run: Trajectory) -> Trajectory:
        way = run.time[:, None, None] * np.array(velocity)
        return replace(run, p_WB=run.p_WB - way, v_WB=run.v_WB - np.array(velocity))

    return Retelling(name="in_motion", scene=replace(scene, bodies=bodies), back=back)


def scaled(scene: Scene, name: str, size: float) -> Retelling:
    """All lengths times `size` under the same gravity: times and speeds go with its root (Froude's number is kept).

    Masses stay, since no motion depends on all of them together. Raises: ValueError for springs, drives, limits, damping and
    prescribed motion.
    """
    speed, clock = float(np.sqrt(size)), float(np.sqrt(size))
    for joint in scene.joints:
        if any(getattr(joint, field, None) is not None for field in ("spring", "drive", "limits", "speed_limit")):
            raise ValueError(f"joint '{joint.name}': has a spring, a drive or limits, which are not scaled")

    def at(vector: Vector3, by: float) -> Vector3:
        return (by * vector[0], by * vector[1], by * vector[2])

    def of(body: Body) -> Body:
        if body.linear_damping > 0 or body.angular_damping > 0:
            raise ValueError(f"body '{body.name}': is damped, which is not scaled")
        if body.prescribed is not None:
            raise ValueError(f"body '{body.name}': its motion is prescribed, which is not scaled")
        parts = tuple(
            replace(placed, shape=scaled_shape(placed.shape, size), p_BS=at(placed.p_BS, size)) for placed in body.collision
        )
        inertia = (np.array(body.inertia) * size**2).tolist()
        there = replace(body, p_WB=at(body.p_WB, size), v_WB=at(body.v_WB, speed), w_WB=at(body.w_WB, 1 / clock))
        return replace(there, inertia=inertia, collision=parts, visual=None)

    def back(run: Trajectory) -> Trajectory:
        return replace(
            run, time=run.time / clock, p_WB=run.p_WB / size, v_WB=run.v_WB / speed, w_WB=run.w_WB * clock, dt=run.dt / clock
        )

    joints = tuple(_anchored(joint, lambda point: at(point, size)) for joint in scene.joints)
    other = replace(scene, bodies=tuple(of(body) for body in scene.bodies), joints=joints)
    return Retelling(name=name, scene=other, back=back, clock=clock)


def _sum(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _anchored(
    joint: Joint, point: Callable[[Vector3], Vector3], axis: Callable[[Vector3], Vector3] = lambda vector: vector
) -> Joint:
    """The joint with other places for its anchors and another direction for its axis."""
    changed: dict[str, Any] = {
        field: point(getattr(joint, field)) for field in ("anchor_W", "child_anchor_W") if hasattr(joint, field)
    }
    if hasattr(joint, "axis_W"):
        changed["axis_W"] = axis(joint.axis_W)
    return replace(joint, **changed)


def _led(
    prescribed: Prescribed | None,
    point: Callable[[Vector3], Vector3],
    axis: Callable[[Vector3], Vector3] = lambda vector: vector,
) -> Prescribed | None:
    """The prescribed motion with another place for its anchor and other directions for its axes."""
    if prescribed is None:
        return None
    turn = prescribed.turn
    return Prescribed(
        shifts=tuple(replace(shift, axis_W=axis(shift.axis_W)) for shift in prescribed.shifts),
        turn=None if turn is None else replace(turn, anchor_W=point(turn.anchor_W), axis_W=axis(turn.axis_W)),
    )
