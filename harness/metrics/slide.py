"""Friction: how far, how long and how level bodies slide, whether friction holds what it should, and in every direction alike.

Painleve's coefficient is what multiplies the load on the foot of a sliding rod in the law of its normal acceleration:
A = 1 + (m/I) c (c - mu h), c and h the ways of the centre of mass from the foot along and above the ground. Positive: Coulomb's
law has one solution. Negative: it has none or two, which is the regime of the paradox.
"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Sphere
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate, rotate_back

SOURCE = "Coulomb friction: d = v0^2/(2 mu g), t = v0/(mu g)"
LEVEL = 0.1
"""The share of its first speed at which a body counts as stopping: high enough that the end of a linear ramp is read between
two samples, where engines regularise friction near zero speed."""


@metric("1", SOURCE, empty="the truth moves no body")
def stop_distance_error(run: Run) -> list[float]:
    """horizontal way at the end against the truth's, relative, worst body"""
    truth = run.truth
    errors = []
    for i in run.movable:
        start = np.array(run.bodies[i].p_WB)
        way, due = (float(np.linalg.norm((motion.p_WB[-1, i] - start)[:2])) for motion in (run.actual, truth))
        if due > 0:
            errors.append(abs(way - due) / due)
    return errors


def _stopping(time: Floats, speed: Floats) -> float:
    """When a speed (t,) first falls to LEVEL of its first value [s]; infinite where it never does."""
    level = LEVEL * speed[0]
    below = np.flatnonzero(speed <= level)
    if len(below) == 0:
        return math.inf
    k = int(below[0])
    share = (speed[k - 1] - level) / (speed[k - 1] - speed[k])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


@metric("1", SOURCE, empty="the truth stops no body within the run")
def stop_time_error(run: Run) -> list[float]:
    """time to fall to a tenth of the first speed, relative to the truth's, worst body"""
    truth = run.truth
    errors = []
    for i in run.movable:
        true_speed = np.linalg.norm(truth.v_WB[:, i, :2], axis=1)
        if true_speed[0] > 0 and np.isfinite(stop := _stopping(truth.time, true_speed)):
            errors.append(abs(_stopping(run.actual.time, np.linalg.norm(run.actual.v_WB[:, i, :2], axis=1)) - stop) / stop)
    return errors


@metric("m")
def centre_rise(run: Run) -> float:
    """unilateral contact on a level plane: the greatest rise of a centre of mass over its start, worst body"""
    starts = np.array([run.bodies[i].p_WB[2] for i in run.movable])
    return float(np.max(run.actual.p_WB[:, run.movable, 2] - starts))


@metric("m/s", samples=2)
def creep_speed(run: Run) -> float:
    """static friction holds: mean speed over the window of the bodies that the truth keeps in place, worst body"""
    truth = run.truth
    still = [i for i in run.movable if not np.any(truth.p_WB[:, i] - truth.p_WB[0, i])]
    if not still:
        raise NotMeasurable("the truth holds no body")
    way = np.linalg.norm(run.actual.p_WB[-1, still] - run.actual.p_WB[0, still], axis=1)
    return float(way.max() / (run.actual.time[-1] - run.actual.time[0]))


def _carried(actual: Trajectory, place: int, point_W: Floats) -> Floats:
    """Where a point of a body that is at point_W (3,) in the first sample is at each time, (t, 3) m."""
    arm_B = rotate_back(actual.q_WB[:1, place], (point_W - actual.p_WB[0, place])[None])
    carried: Floats = actual.p_WB[:, place] + rotate(actual.q_WB[:, place], np.broadcast_to(arm_B, (len(actual), 3)))
    return carried


@metric("m", contacts=True)
def foot_slip(run: Run) -> float:
    """static friction holds: greatest way along the ground of the material points that bear on it when the window begins"""
    movable, first = [body.movable for body in run.bodies], run.contacts[0]
    ways = []
    for a, b, point, normal, force in zip(
        first.body_A, first.body_B, first.point_W, first.normal_W, first.force_W, strict=True
    ):
        # A near miss that an engine lists bears nothing.
        if movable[a] != movable[b] and force.any():
            way = _carried(run.actual, a if movable[a] else b, point) - point
            ways.append(np.linalg.norm(way - np.outer(way @ normal, normal), axis=1).max())
    # A machine that hangs in the air has no foot on the ground that could hold.
    return float(np.max(ways)) if ways else math.inf


ISOTROPY_SOURCE = "Coulomb's cone is round: |f| <= mu N in every direction of the plane"


def _ways(run: Run) -> tuple[Floats, Floats]:
    """Horizontal displacements (n, 2) m at the end and the directions (n, 2) of the pushes."""
    pushed = [i for i in run.movable if math.hypot(*run.bodies[i].v_WB[:2]) > 0]
    if len(pushed) < 2:
        raise NotMeasurable(f"{len(pushed)} bodies are pushed, expected at least two")
    starts = np.array([run.bodies[i].p_WB[:2] for i in pushed])
    pushes = np.array([run.bodies[i].v_WB[:2] for i in pushed])
    ways: Floats = run.actual.p_WB[-1, pushed, :2] - starts
    return ways, pushes / np.linalg.norm(pushes, axis=1, keepdims=True)


@metric("1", ISOTROPY_SOURCE)
def polar_spread(run: Run) -> float:
    """(greatest - least) / mean stopping distance over all azimuths"""
    ways, _ = _ways(run)
    distance = np.linalg.norm(ways, axis=1)
    return float((distance.max() - distance.min()) / distance.mean()) if distance.mean() > 0 else math.nan


@metric("rad", ISOTROPY_SOURCE)
def heading_error(run: Run) -> float:
    """greatest angle between push and displacement"""
    ways, pushes = _ways(run)
    if not np.linalg.norm(ways, axis=1).all():
        return math.nan
    across = ways[:, 0] * pushes[:, 1] - ways[:, 1] * pushes[:, 0]
    return float(np.max(np.abs(np.arctan2(across, np.sum(ways * pushes, axis=1)))))


@metric("1", better="higher")
def painleve_coefficient(run: Run) -> float:
    """Genot, Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653, with a rounded foot: least value over the run; below 0 Coulomb's
    law and rigidity contradict each other"""
    bodies = run.movable
    if len(bodies) != 1:
        raise NotMeasurable(f"{len(bodies)} movable bodies, expected one")
    rod = run.bodies[bodies[0]]
    feet = [placed for placed in rod.collision if isinstance(placed.shape, Sphere)]
    grounds = [body for body in run.bodies if run.scene.collides(rod, body)]
    if len(feet) != 2 or len(feet) != len(rod.collision) or len(grounds) != 1:
        raise NotMeasurable(f"body '{rod.name}' is no rod with two round ends on one ground")
    friction = run.scene.surface(rod, grounds[0]).kinetic_friction
    smallest = np.inf
    for foot in feet:
        arm = -rotate(run.actual.q_WB[:, bodies[0]], np.broadcast_to(foot.p_BS, (len(run.actual), 3)))
        along, above = np.hypot(arm[:, 0], arm[:, 1]), arm[:, 2] + getattr(foot.shape, "radius", 0.0)
        inertia = float(np.linalg.eigvalsh(np.array(rod.inertia))[-1])
        coefficient = 1 + rod.mass / inertia * along * (along - friction * above)
        # The end that is up has its arm downwards, and a coefficient that is never small.
        smallest = np.minimum(smallest, np.min(coefficient))
    return float(smallest)
