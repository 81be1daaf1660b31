"""Bouncing of balls on a level plane, read off the parabolas between impacts.

Positions alone are read: between impacts every engine's heights lie on a parabola of curvature -g, also where a
semi-implicit scheme keeps velocities half a step aside, so apexes and landings are found between samples and free of
that artefact. A hop of fewer than three samples is not seen; it counts as no bounce.
"""

import math
from itertools import pairwise

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Plane, Scene, Sphere
from plumbline.harness.trajectory import Floats, Trajectory

SOURCE = "Stronge, Impact Mechanics, 2nd ed. (kinematic coefficient); apexes h' = e^2 h"
FREE = 0.1
"""Share of g by which a vertical acceleration may miss -g and still be free flight: above any hidden damping at these speeds,
below any support."""
HOP = 1e-4
"""Height over contact, as a share of the drop, from which a ball counts as off the ground: its hops there take a hundredth of
the time of fall, and what a solver leaves of a gap at rest is far less."""

FAST = 0.5
"""Share of the speed of the first impact from which on later ones are looked at: slower ones are short beside their step."""

Flight = tuple[float, float]
"""Apex over the plane [m] and time of landing [s]."""


def _balls(scene: Scene) -> list[tuple[int, float, float]]:
    """Place, height of the centre in contact [m] and restitution of each ball over the scene's plane."""
    planes = [b for b in scene.bodies if not b.movable and any(isinstance(s.shape, Plane) for s in b.collision)]
    balls = []
    for place, body in enumerate(scene.bodies):
        shapes = [placed.shape for placed in body.collision]
        if body.movable and planes and len(shapes) == 1 and isinstance(shapes[0], Sphere):
            restitution = scene.surface(body, planes[0]).restitution
            balls.append((place, planes[0].p_WB[2] + shapes[0].radius, restitution))
    if not balls or scene.gravity[2] >= 0:
        raise NotMeasurable("no ball falls on a plane")
    return balls


def _flights(time: Floats, gap: Floats, gravity: float) -> list[Flight]:
    """The free flights of one ball in order; gap (t,) m is the height over contact, gravity [m/s2] positive."""
    spacing = np.diff(time)
    whole = int(np.sum(np.isclose(spacing, spacing[0], rtol=1e-6))) + 1 if len(spacing) else 0
    if whole < 3:
        raise NotMeasurable("fewer than three evenly spaced samples")
    time, gap, interval = time[:whole], gap[:whole], float(spacing[0])
    fall = gravity * interval**2
    free = np.abs(gap[2:] - 2 * gap[1:-1] + gap[:-2] + fall) <= FREE * fall
    slope = (gap[2:] - gap[:-2]) / (2 * interval)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], free.astype(np.int64), [0]))))
    flights = []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        top = start + int(np.argmax(gap[start + 1 : end + 1]))
        apex = float(gap[top + 1] + slope[top] ** 2 / (2 * gravity))
        fallen = max(slope[end - 1] ** 2 + 2 * gravity * gap[end], 0.0)
        flights.append((apex, float(time[end] + (slope[end - 1] + math.sqrt(fallen)) / gravity)))
    return flights


def _all_flights(scene: Scene, run: Trajectory) -> list[tuple[float, list[Flight]]]:
    return [(e, _flights(run.time, run.p_WB[:, i, 2] - at, -scene.gravity[2])) for i, at, e in _balls(scene)]


def _bounces(flights: list[Flight], count: int) -> list[float]:
    """Effective restitutions of the first `count` impacts; 0 where no flight follows, NaN where the ball never fell."""
    if not flights:
        return [math.nan] * count
    apexes = [max(apex, 0.0) for apex, _ in flights[: count + 1]]
    apexes += [0.0] * (count + 1 - len(apexes))
    return [math.sqrt(after / before) if before > 0 else 0.0 for before, after in pairwise(apexes)]


@metric("1", SOURCE, even=True)
def bounce_height_error(run: Run) -> list[float]:
    """|h'/h - e^2| of the first bounce, worst ball; linear in small errors, as an error of e is not at e = 0"""
    return [abs(_bounces(flights, 1)[0] ** 2 - e**2) for e, flights in _all_flights(run.scene, run.actual)]


@metric("1", SOURCE, even=True)
def restitution_error(run: Run) -> list[float]:
    """first impact, worst ball"""
    return [abs(_bounces(flights, 1)[0] - e) for e, flights in _all_flights(run.scene, run.actual)]


@metric("1", SOURCE, even=True, empty="no second or third bounce comes in with half the speed of the first")
def later_restitution_error(run: Run) -> list[float]:
    """second and third impact where they come in with half the first speed, worst ball"""
    if run.expected is None:
        raise NotMeasurable("no truth to say which bounces fall into the run")
    errors = []
    for (e, flights), (_, true_flights) in zip(
        _all_flights(run.scene, run.actual), _all_flights(run.scene, run.expected), strict=True
    ):
        # Bounce n + 1 comes in with e^n of the first speed; its flight must have begun and passed its apex within the truth.
        asked = [
            n for n in (1, 2) if e**n >= FAST and len(true_flights) > n + 1 and true_flights[n + 1][1] <= run.expected.time[-1]
        ]
        bounces = _bounces(flights, 3)
        errors += [abs(bounces[n] - e) for n in asked]
    return errors


@metric("s", SOURCE, even=True, empty="no impact falls into the run")
def impact_time_error(run: Run) -> list[float]:
    """landings of the first two parabolas against the truth's, worst ball"""
    if run.expected is None:
        raise NotMeasurable("no truth with impact times")
    errors = []
    for (_, flights), (_, true_flights) in zip(
        _all_flights(run.scene, run.actual), _all_flights(run.scene, run.expected), strict=True
    ):
        for n, (_, landing) in enumerate(true_flights[:2]):
            if landing <= run.expected.time[-1]:
                errors.append(abs(flights[n][1] - landing) if n < len(flights) else math.inf)
    return errors


def _last_hop(scene: Scene, run: Trajectory) -> list[float]:
    """The last instant [s] at which each ball is off the ground."""
    ends = []
    for place, at, _ in _balls(scene):
        drop = scene.bodies[place].p_WB[2] - at
        up = np.flatnonzero(run.p_WB[:, place, 2] - at > HOP * drop)
        ends.append(float(run.time[up[-1]]) if len(up) else float(run.time[0]))
    return ends


@metric(
    "s",
    f"{SOURCE}, t0 (1 + e)/(1 - e) in all; last instant off the ground by {HOP:g} of the drop, against the truth's, "
    "worst ball that comes to rest",
    even=True,
    empty="no ball comes to rest within the run",
)
def bouncing_time_error(run: Run) -> list[float]:
    if run.expected is None or len(run.expected) == 0:
        raise NotMeasurable("no truth to say when all bouncing ends")
    pairs = zip(_last_hop(run.scene, run.actual), _last_hop(run.scene, run.expected), strict=True)
    # What still hops at the end of the truth has no end to compare with.
    return [abs(measured - true) for measured, true in pairs if true < run.expected.time[-2]]


@metric("1", even=True, empty="no ball bounces twice from a quarter of its drop or more")
def bounce_gain(run: Run) -> list[float]:
    """conservation of energy: by how much a bounce rises above the one before, h'/h - 1, worst bounce of the worst ball that
    comes in with half the speed of its drop or more; below 0 where every bounce loses"""
    gains = []
    for (place, at, _), (_, flights) in zip(_balls(run.scene), _all_flights(run.scene, run.actual), strict=True):
        apexes = [apex for apex, _ in flights]
        high = FAST**2 * (run.scene.bodies[place].p_WB[2] - at)
        gains += [after / before - 1 for before, after in pairwise(apexes) if before >= high] if apexes else [math.nan]
    return gains
