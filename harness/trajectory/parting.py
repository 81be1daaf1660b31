"""How far two motions of one scene lie apart, as a share of the size of what moves.

A body that stands d away and is turned by an angle a has moved each of its points by d + r a at most, with its radius of
gyration r for the distance of a point that counts. That is taken over the size of the whole that the body belongs to: all
bodies that joints hold together, or the body alone. So one number, with one tolerance, serves a robot of a metre and the
pebble beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.harness.scene import WORLD, Scene
from plumbline.harness.trajectory.kinematics import conjugate, movable, product
from plumbline.harness.trajectory.trajectory import Floats, Integers, Trajectory


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """What the distances of a scene are measured by.

    Terms:
        bodies (m,): places of those that a force moves. size (m,) m: of the whole that each belongs to. gyration (m,) m: the
        largest radius of gyration of each.
    """

    bodies: Integers
    size: Floats
    gyration: Floats

    @property
    def largest(self) -> float:
        """The size [m] of the largest whole."""
        return float(self.size.max(initial=0.0))


NOTHING = Extent(bodies=np.zeros(0, np.int64), size=np.zeros(0), gyration=np.zeros(0))
"""Of no scene."""


def extent(scene: Scene) -> Extent:
    """The sizes of a scene: the diagonal of the box around a whole, its anchors and its bodies' radii of gyration included."""
    places = movable(scene)
    gyration = np.array([_gyration(scene, place) for place in places.tolist()])
    whole, size = _wholes(scene), {}
    for name in set(whole.values()):
        members = [place for place in places.tolist() if whole[scene.bodies[place].name] == name]
        names = {scene.bodies[place].name for place in members}
        # A ball of radius r is 2.2 r wide in this way, a long rod 2 % longer than it is.
        corners = [np.array(scene.bodies[k].p_WB) + sign * _gyration(scene, k) for k in members for sign in (-1.0, 1.0)]
        corners += [
            np.array(point)
            for joint in scene.joints
            for point in (getattr(joint, "anchor_W", None), getattr(joint, "child_anchor_W", None))
            if point is not None and names & {joint.parent, joint.child}
        ]
        size[name] = float(np.linalg.norm(np.ptp(np.array(corners), axis=0)))
    return Extent(
        bodies=places, size=np.array([size[whole[scene.bodies[place].name]] for place in places.tolist()]), gyration=gyration
    )


def _gyration(scene: Scene, place: int) -> float:
    body = scene.bodies[place]
    return float(np.sqrt(np.linalg.eigvalsh(np.array(body.inertia))[-1] / body.mass))


def _wholes(scene: Scene) -> dict[str, str]:
    """The name of a whole, by that of each movable body in it: bodies that joints hold together, the world left out."""
    above = {body.name: body.name for body in scene.bodies if body.movable}

    def top(name: str) -> str:
        while above[name] != name:
            name = above[name]
        return name

    for joint in scene.joints:
        if joint.parent != WORLD and joint.parent in above and joint.child in above:
            above[top(joint.child)] = top(joint.parent)
    return {name: top(name) for name in above}


def offsets(run: Trajectory, base: Trajectory, scale: Extent) -> Floats:
    """Where a run lies from another at the same times, (t, m, 6): displacement and turn in W, as shares of the size.

    The turn is a vector along its axis, as long as its angle [rad], times the radius of gyration.
    """
    b = scale.bodies
    turn = product(run.q_WB[:, b], conjugate(base.q_WB[:, b]))
    turn = turn * np.where(turn[..., :1] < 0, -1.0, 1.0)
    sine = np.linalg.norm(turn[..., 1:], axis=-1)
    angle = 2.0 * np.arctan2(sine, turn[..., 0])
    # For no turn the axis is any, and angle over sine is 2.
    along = turn[..., 1:] * np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)[..., None]
    moved = run.p_WB[:, b] - base.p_WB[:, b]
    return np.concatenate([moved / scale.size[:, None], along * (scale.gyration / scale.size)[:, None]], axis=-1)


def length(offset: Floats) -> Floats:
    """The largest of all bodies at each sample, (t,): of the displacement and the turn, added up."""
    parts = np.linalg.norm(offset[..., :3], axis=-1) + np.linalg.norm(offset[..., 3:], axis=-1)
    largest: Floats = parts.max(axis=1, initial=0.0)
    return largest


def apart(run: Trajectory, base: Trajectory, scale: Extent) -> Floats:
    """The share of their size by which the bodies of two runs at the same times lie apart at most, (t,)."""
    return length(offsets(run, base, scale))


def displaced(base: Trajectory, offset: Floats, scale: Extent) -> Trajectory:
    """The poses of a run, moved by offsets (t, m, 6) from it; velocities stay."""
    p_WB, q_WB, b = base.p_WB.copy(), base.q_WB.copy(), scale.bodies
    p_WB[:, b] += offset[..., :3] * scale.size[:, None]
    turn = offset[..., 3:] * (scale.size / scale.gyration)[:, None]
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    axis = turn / np.where(angle > 0, angle, 1.0)
    q_WB[:, b] = product(np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * axis], axis=-1), base.q_WB[:, b])
    return replace(base, p_WB=p_WB, q_WB=q_WB, contacts=None, streams={})


def common(runs: Sequence[Trajectory]) -> list[Trajectory]:
    """Runs cut to the samples that all of them have."""
    times = runs[0].time
    for run in runs[1:]:
        times = times[np.isin(np.round(times, 9), np.round(run.time, 9))]
    cut = []
    for run in runs:
        keep = np.isin(np.round(run.time, 9), np.round(times, 9))
        cut.append(Trajectory(run.time[keep], run.p_WB[keep], run.q_WB[keep], run.v_WB[keep], run.w_WB[keep], dt=run.dt))
    return cut
