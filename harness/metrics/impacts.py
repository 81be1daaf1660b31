"""Impacts of balls: how they bounce on a level plane, and what goes through a row of them.

Bounces are read off the parabolas between impacts. Positions alone are read: between impacts every engine's heights lie on a
parabola of curvature -g, also where a semi-implicit scheme keeps velocities half a step aside, so apexes and landings are found
between samples and free of that artefact. A hop of fewer than three samples is not seen; it counts as no bounce.

A row is all movable balls of one material, on one line; the first is the one that moves at the start. In a row with gaps each
elastic blow hands everything on, so that the last ball carries all; in a row that touches that is one of many outcomes that
keep momentum and energy.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Plane, Scene, Sphere, outer_radius
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
        if body.movable and planes and isinstance(body.only_shape, Sphere):
            restitution = scene.surface(body, planes[0]).restitution
            balls.append((place, planes[0].p_WB[2] + body.only_shape.radius, restitution))
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


def _beside_truth(run: Run) -> Iterator[tuple[float, list[Flight], list[Flight]]]:
    """Of each ball the restitution, its flights and the truth's."""
    for (e, flights), (_, due) in zip(_all_flights(run.scene, run.actual), _all_flights(run.scene, run.truth), strict=True):
        yield e, flights, due


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
    errors, end = [], run.truth.time[-1]
    for e, flights, true_flights in _beside_truth(run):
        # Bounce n + 1 comes in with e^n of the first speed; its flight must have begun and passed its apex within the truth.
        asked = [n for n in (1, 2) if e**n >= FAST and len(true_flights) > n + 1 and true_flights[n + 1][1] <= end]
        bounces = _bounces(flights, 3)
        errors += [abs(bounces[n] - e) for n in asked]
    return errors


@metric("s", SOURCE, even=True, empty="no impact falls into the run")
def impact_time_error(run: Run) -> list[float]:
    """landings of the first two parabolas against the truth's, worst ball"""
    errors = []
    for _, flights, true_flights in _beside_truth(run):
        for n, (_, landing) in enumerate(true_flights[:2]):
            if landing <= run.truth.time[-1]:
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
    samples=2,
    empty="no ball comes to rest within the run",
)
def bouncing_time_error(run: Run) -> list[float]:
    pairs = zip(_last_hop(run.scene, run.actual), _last_hop(run.scene, run.truth), strict=True)
    # What still hops at the end of the truth has no end to compare with.
    return [abs(measured - true) for measured, true in pairs if true < run.truth.time[-2]]


@metric("1", even=True, empty="no ball bounces twice from a quarter of its drop or more")
def bounce_gain(run: Run) -> list[float]:
    """conservation of energy: by how much a bounce rises above the one before, h'/h - 1, worst bounce of the worst ball that
    comes in with half the speed of its drop or more; below 0 where every bounce loses"""
    gains = []
    for (place, at, _), (_, flights) in zip(_balls(run.scene), _all_flights(run.scene, run.actual), strict=True):
        apexes = [apex for apex, _ in flights]
        high = FAST**2 * (run.bodies[place].p_WB[2] - at)
        gains += [after / before - 1 for before, after in pairwise(apexes) if before >= high] if apexes else [math.nan]
    return gains


ROW_SOURCE = "Herrmann, Schmaelzle, Am. J. Phys. 49 (1981) 761 (a row with gaps is a chain of pairs)"
CONTACT = 1e-9
"""Gaps below this [m] are none: the rounding of places of some metres, a million times over."""


def _rows(scene: Scene) -> list[tuple[list[int], Floats, float]]:
    """Of each row: places of the balls from the first to the last, the way of the first, the narrowest gap [m]."""
    kinds: dict[str, list[int]] = {}
    for place, body in enumerate(scene.bodies):
        if body.movable and isinstance(body.only_shape, Sphere):
            kinds.setdefault(body.material, []).append(place)
    rows = []
    for places in kinds.values():
        moving = [place for place in places if any(scene.bodies[place].v_WB)]
        if len(places) < 2 or len(moving) != 1:
            continue
        v_WB = np.array(scene.bodies[moving[0]].v_WB)
        way = v_WB / np.linalg.norm(v_WB)
        ordered = sorted(places, key=lambda place: float(np.array(scene.bodies[place].p_WB) @ way))
        along = [float(np.array(scene.bodies[place].p_WB) @ way) for place in ordered]
        radii = np.array([outer_radius(placed.shape) for place in ordered for placed in scene.bodies[place].collision])
        gaps = np.diff(along) - radii[1:] - radii[:-1]
        rows.append((ordered, way, float(gaps[1:].min()) if len(gaps) > 1 else float(gaps[0])))
    if not rows:
        raise NotMeasurable("no row of balls of which one moves")
    return rows


def _share(scene: Scene, actual: Trajectory, places: list[int], way: Floats) -> float:
    """The last ball's share of the momentum that the first one brought."""
    first, last = scene.bodies[places[0]], scene.bodies[places[-1]]
    brought = first.mass * float(np.linalg.norm(first.v_WB))
    return last.mass * float(actual.v_WB[-1, places[-1]] @ way) / brought


@metric("1", ROW_SOURCE, empty="every row touches")
def last_share_error(run: Run) -> list[float]:
    """|share of the last ball in the momentum of the first - 1|, worst row with gaps"""
    return [abs(_share(run.scene, run.actual, places, way) - 1) for places, way, gap in _rows(run.scene) if gap > CONTACT]


@metric("1", better="higher")
def touching_last_share(run: Run) -> float:
    """definition: share of the last ball in the momentum of the first, mean of the rows that touch"""
    shares = [_share(run.scene, run.actual, places, way) for places, way, gap in _rows(run.scene) if gap <= CONTACT]
    if not shares:
        raise NotMeasurable("no row touches")
    return float(np.mean(shares))
