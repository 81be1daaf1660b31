"""Sticking and sliding of boxes on inclines: the threshold angle and the acceleration beyond it."""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Scene, rotate

SOURCE = "Coulomb friction on an incline: slides iff tan(angle) > mu, then a = g (sin - mu cos)"

Slope = tuple[float, float, float, float]
"""Angle [rad], friction coefficient, acceleration in truth (negative: margin of sticking) and as measured [m/s2]."""


def _friction(scene: Scene, body: Body) -> float:
    for other in scene.bodies:
        if not other.movable and scene.collides(body, other):
            return scene.surface(body, other).kinetic_friction
    raise NotMeasurable(f"body '{body.name}' has nothing to rest on")


def _slopes(run: Run) -> list[Slope]:
    """One row a box; its base is parallel to the incline at the start, and it starts at rest."""
    g = float(np.linalg.norm(run.scene.gravity))
    if g == 0 or len(run.actual) == 0 or run.actual.time[-1] <= 0:
        raise NotMeasurable("no gravity or no time to slide")
    slopes = []
    for place, body in enumerate(run.scene.bodies):
        if body.movable:
            normal = np.array(rotate(body.q_WB, (0.0, 0.0, 1.0)))
            pull = np.array(run.scene.gravity)
            along = pull - normal * (pull @ normal)
            angle = math.atan2(float(np.linalg.norm(along)), float(-pull @ normal))
            mu = _friction(run.scene, body)
            way = float((run.actual.p_WB[-1, place] - np.array(body.p_WB)) @ along / np.linalg.norm(along))
            slopes.append((angle, mu, g * (math.sin(angle) - mu * math.cos(angle)), 2 * way / float(run.actual.time[-1]) ** 2))
    if not slopes:
        raise NotMeasurable("no box stands on an incline")
    return slopes


@metric("1", SOURCE, verdict="a box covers half the way that it would on the incline nearest to the threshold")
def threshold_angle_error(run: Run) -> float:
    """middle between the flattest incline that does not hold and the steepest below it that does, relative to atan(mu)"""
    slopes = _slopes(run)
    if len({mu for _, mu, _, _ in slopes}) > 1:
        raise NotMeasurable("the boxes differ in friction, so that there is no common threshold")
    # A box slides when it covers half the way that the incline nearest to the threshold makes: more than creep, and still less
    # than what any incline beyond a wrong threshold would show.
    least = min(abs(true) for _, _, true, _ in slopes) / 2
    sliding = min([math.pi / 2, *(angle for angle, _, _, acceleration in slopes if acceleration > least)])
    # What holds on a steeper incline than one that slides is no threshold: wrong fates would make up for each other.
    sticking = max([0.0, *(angle for angle, _, _, acceleration in slopes if acceleration <= least and angle < sliding)])
    true_angle = math.atan(slopes[0][1])
    return abs((sticking + sliding) / 2 - true_angle) / true_angle


@metric("1", SOURCE)
def incline_acceleration_error(run: Run) -> float:
    """mean acceleration 2 s/t^2 of the boxes that slide in truth, error over g, worst box"""
    slopes = _slopes(run)
    errors = [abs(acceleration - true) for _, _, true, acceleration in slopes if true > 0]
    if not errors:
        raise NotMeasurable("no incline is steep enough to slide")
    return float(np.max(errors)) / float(np.linalg.norm(run.scene.gravity))
