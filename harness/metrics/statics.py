"""Statics at a threshold: on which side of it does each of several stages stand or fall?

Sticking and sliding of boxes on inclines: the threshold angle and the acceleration beyond it.

Boxes on inclines that hold, slide or tip over: is the fate of each what statics says, and at which angle do they tip?

A box of half length b along the fall line and half height h tips about its lower edge iff tan(angle) > b/h, if friction holds
it until then, mu >= b/h; else it slides iff tan(angle) > mu, without tipping.
Source: Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3.

A-frames of two cards that lean against each other: at which friction of their feet do they stand, and for how long?

Two equal cards of half length l and half thickness c stand at the angle a to the vertical on their lower edges and lean edge to
edge. Each bears its own weight W at its foot; the moments about it ask for a thrust H = W (tan a - c/l)/2 at the top, which
friction at the foot has to balance: the frame stands iff

    mu >= (tan a - c/l)/2

if the cards hold on to each other. A frame is two movable boxes, one after the other in the scene.
Source: Beer, Johnston, Vector Mechanics: Statics, 12th ed., sections 6.3 and 8.1 (frames; dry friction).

Overhang: how far bricks laid on each other reach beyond the edge of a table before they fall. A stack is a static box, the
table, and the movable boxes that follow it in the scene, from the lowest to the highest. Bricks of length l, each with its end
beyond the one below, stand iff the common centre of mass of those above each edge lies inside of it; n bricks reach at most

    l/2 (1 + 1/2 + ... + 1/n).

Source: Hall, Fun with Stacking Blocks, Am. J. Phys. 73 (2005) 1107; Paterson, Zwick, Overhang, Am. Math. Monthly 116 (2009) 19.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import other_starts
from plumbline.harness.scene import Body, Box, Scene, Surface, rotate
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate as rotate_along

SOURCE = "Coulomb friction on an incline: slides iff tan(angle) > mu, then a = g (sin - mu cos)"


def _threshold(stages: Iterable[tuple[float, bool]], most: float) -> float:
    """The middle between the least stage that fails, `most` where none does, and the greatest below it that holds.

    What holds beyond one that fails is no threshold: else wrong fates would make up for each other.

    Args: stages: where each is, and whether it fails.
    """
    fates = list(stages)
    failing = min([most, *(stage for stage, fails in fates if fails)])
    return (max([0.0, *(stage for stage, fails in fates if not fails and stage < failing)]) + failing) / 2


Slope = tuple[float, float, float, float]
"""Angle [rad], friction coefficient, acceleration in truth (negative: margin of sticking) and as measured [m/s2]."""


def _law(scene: Scene, body: Body) -> Surface:
    """The law of contact of a body with what it rests on."""
    for other in scene.bodies:
        if not other.movable and scene.collides(body, other):
            return scene.surface(body, other)
    raise NotMeasurable(f"body '{body.name}' has nothing to rest on")


def _slopes(run: Run) -> list[Slope]:
    """One row a box; its base is parallel to the incline at the start, and it starts at rest."""
    g = float(np.linalg.norm(run.scene.gravity))
    if g == 0 or run.actual.time[-1] <= 0:
        raise NotMeasurable("no gravity or no time to slide")
    slopes = []
    for place, body in enumerate(run.bodies):
        if body.movable:
            normal = np.array(rotate(body.q_WB, (0.0, 0.0, 1.0)))
            pull = np.array(run.scene.gravity)
            along = pull - normal * (pull @ normal)
            angle = math.atan2(float(np.linalg.norm(along)), float(-pull @ normal))
            mu = _law(run.scene, body).kinetic_friction
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
    threshold = _threshold(((angle, acceleration > least) for angle, _, _, acceleration in slopes), math.pi / 2)
    true_angle = math.atan(slopes[0][1])
    return abs(threshold - true_angle) / true_angle


@metric("1", SOURCE, empty="no incline is steep enough to slide")
def incline_acceleration_error(run: Run) -> list[float]:
    """mean acceleration 2 s/t^2 of the boxes that slide in truth, error over g, worst box"""
    g = float(np.linalg.norm(run.scene.gravity))
    return [abs(acceleration - true) / g for _, _, true, acceleration in _slopes(run) if true > 0]


TIPPING_SOURCE = "Meriam, Kraige, Statics, section 6/3: tips iff tan(angle) > b/h before it slides at tan(angle) = mu"
TIPPED = 0.5
"""Tilt of a box's upward axis from its start [rad] from which it has tipped: more than b/h of a tall box. One that slides may
turn about that axis as far as it likes."""


@dataclass(frozen=True, slots=True)
class _Fate:
    """What became of a box, what should have, tan(angle) of its incline and of where it tips [1]."""

    found: Literal["holds", "slides", "tips"]
    true: Literal["holds", "slides", "tips"]
    slope: float
    tips_at: float


def _fates(run: Run) -> list[_Fate]:
    g = np.array(run.scene.gravity)
    if not g.any() or run.actual.time[-1] <= 0:
        raise NotMeasurable("no gravity or no time to move")
    fates = []
    for place, body in enumerate(run.bodies):
        if not body.movable:
            continue
        shape = body.only_shape
        if not isinstance(shape, Box):
            raise NotMeasurable(f"body '{body.name}' is no single box")
        along, normal = (np.array(rotate(body.q_WB, axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        pull, load = float(g @ along), float(-g @ normal)
        slope, tips_at = pull / load, shape.half_extents[0] / shape.half_extents[2]
        mu = _law(run.scene, body).kinetic_friction
        true: Literal["holds", "slides", "tips"] = "holds"
        if slope > min(mu, tips_at):
            true = "tips" if tips_at <= mu else "slides"
        upward = rotate_along(run.actual.q_WB[:, place], np.array([0.0, 0.0, 1.0]))
        turned = float(np.max(np.arctan2(np.linalg.norm(np.cross(upward, normal), axis=1), upward @ normal)))
        way = float((run.actual.p_WB[-1, place] - np.array(body.p_WB)) @ along)
        # Half of the way that it would make in truth, and a tenth of its length where it should not slide at all.
        least = (pull - mu * load) * float(run.actual.time[-1]) ** 2 / 4 if true == "slides" else shape.half_extents[0] / 5
        became: Literal["holds", "slides", "tips"] = "tips" if turned > TIPPED else "slides" if way > least else "holds"
        fates.append(_Fate(became, true, slope, tips_at))
    if not fates:
        raise NotMeasurable("no box stands on an incline")
    return fates


@metric("1", TIPPING_SOURCE, verdict="a box tilts by half a radian, or slides by half its due way or a tenth of its length")
def wrong_fates(run: Run) -> float:
    """number of boxes that hold, slide or tip (by 0.5 rad) where they should not"""
    return float(sum(fate.found != fate.true for fate in _fates(run)))


@metric("1", TIPPING_SOURCE, verdict="a box tilts by half a radian")
def tipping_angle_error(run: Run) -> float:
    """middle between the flattest incline on which a box tips and the steepest below it on which none does, over atan(b/h),
    less 1"""
    fates = _fates(run)
    # The boxes that tip in truth at a steeper incline, if not at their own; they have one shape.
    tall = [fate for fate in fates if fate.true == "tips"]
    if not tall:
        raise NotMeasurable("no incline is steep enough to tip a box")
    tips_at = tall[0].tips_at
    alike = [fate for fate in fates if fate.tips_at == tips_at and fate.true != "slides"]
    threshold = _threshold(((math.atan(fate.slope), fate.found == "tips") for fate in alike), math.pi / 2)
    return abs(threshold / math.atan(tips_at) - 1)


FRAMES_SOURCE = "statics of an A-frame: stands iff mu >= (tan a - c/l)/2"


def critical_friction(angle: float, half_length: float, half_thickness: float) -> float:
    """The least friction [1] at the feet of cards at `angle` [rad] to the vertical; half extents [m]."""
    return (math.tan(angle) - half_thickness / half_length) / 2


@dataclass(frozen=True, slots=True)
class _Frame:
    """Friction at the feet over the critical one [1], and the time [s] for which no card sank to half of its height."""

    friction: float
    stood: float


def _frames(run: Run) -> list[_Frame]:
    """All frames; a card stands along the z axis of its body, its thickness along x."""
    cards = run.movable
    if len(cards) < 2 or len(cards) % 2:
        raise NotMeasurable(f"{len(cards)} cards, expected pairs")
    frames = []
    for pair in zip(cards[::2], cards[1::2], strict=True):
        card = run.bodies[pair[0]]
        shape = card.only_shape
        if not isinstance(shape, Box):
            raise NotMeasurable(f"body '{card.name}' is no single box")
        angle = math.acos(rotate(card.q_WB, (0.0, 0.0, 1.0))[2])
        critical = critical_friction(angle, shape.half_extents[2], shape.half_extents[0])
        start = np.array([run.bodies[i].p_WB[2] for i in pair])
        sunk = np.any(run.actual.p_WB[:, pair, 2] < start / 2, axis=1)
        stood = float(run.actual.time[np.argmax(sunk)] if sunk.any() else math.inf)
        frames.append(_Frame(_law(run.scene, card).static_friction / critical, stood))
    return frames


@metric("1", FRAMES_SOURCE, verdict="a card of a frame sinks below half of its height")
def frame_friction_error(run: Run) -> float:
    """middle between the greatest friction that falls and the least above it that stands, over the critical, less 1"""
    frames = _frames(run)
    # Where all stand the threshold is taken for half of the least friction's; where all fall, for twice the greatest.
    falls = max([0.0, *(frame.friction for frame in frames if math.isfinite(frame.stood))])
    most = 2 * max(frame.friction for frame in frames)
    # What stands with less friction than one that falls is no threshold: a pair of wrong fates would make up for each other.
    stands = min([most, *(frame.friction for frame in frames if math.isinf(frame.stood) and frame.friction > falls)])
    return abs((falls + stands) / 2 - 1)


@metric(
    "s",
    FRAMES_SOURCE,
    better="higher",
    verdict="a card of a frame that has the friction to stand sinks below half of its height",
)
def frame_standing_time(run: Run) -> float:
    """the least time for which a frame stands that should; the run's length where all do"""
    times = [min(frame.stood, float(run.actual.time[-1])) for frame in _frames(run) if frame.friction >= 1]
    if not times:
        raise NotMeasurable("no frame has the friction to stand")
    return min(times)


def harmonic_overhang(n: int) -> float:
    """The greatest overhang of n bricks, one on the other, in lengths of a brick."""
    return sum(1 / k for k in range(1, n + 1)) / 2


def _half_extents(body: Body) -> tuple[float, float, float]:
    if not isinstance(body.only_shape, Box):
        raise NotMeasurable(f"body '{body.name}' is no single box")
    return body.only_shape.half_extents


def _stacks(scene: Scene) -> list[tuple[float, list[int]]]:
    """Overhang over the limit [1] and the places of the bricks of each stack."""
    starts = [place for place, body in enumerate(scene.bodies) if not body.movable]
    stacks = []
    for table, end in zip(starts, [*starts[1:], len(scene.bodies)], strict=True):
        bricks = list(range(table + 1, end))
        if not bricks:
            continue
        edge = scene.bodies[table].p_WB[0] + _half_extents(scene.bodies[table])[0]
        reach = max(scene.bodies[i].p_WB[0] + _half_extents(scene.bodies[i])[0] for i in bricks) - edge
        length = 2 * _half_extents(scene.bodies[bricks[0]])[0]
        stacks.append((reach / length / harmonic_overhang(len(bricks)), bricks))
    if not stacks:
        raise NotMeasurable("no bricks on a table")
    return stacks


@metric("1", verdict="a brick ends lower by more than its half thickness")
def overhang_limit_error(run: Run) -> float:
    """Hall 2005; middle between the shortest overhang that falls and the longest below it that stands, over the limit, less
    1; of several starts the middle one's"""
    stacks = _stacks(run.scene)
    ends = [run.actual.p_WB[-1], *(p_WB[-1] for p_WB in other_starts(run, "p_WB"))]
    return float(np.median([abs(_overhang_limit(run, stacks, end) - 1) for end in ends]))


def _overhang_limit(run: Run, stacks: Sequence[tuple[float, list[int]]], p_WB: Floats) -> float:
    """The limit over the true one, from where the bodies are in the end (n, 3) m; infinite where a start diverged."""
    if not np.isfinite(p_WB).all():
        return math.inf
    # Where all stand the limit is taken for at least twice the longest; where all fall, for half of the shortest.
    fates = []
    for overhang, bricks in stacks:
        start = np.array([run.bodies[i].p_WB[2] for i in bricks])
        # A brick has fallen when it has sunk by its own half thickness: what tips over the edge below does.
        thick = np.array([_half_extents(run.bodies[i])[2] for i in bricks])
        fates.append((overhang, bool(np.any(start - p_WB[bricks, 2] > thick))))
    return _threshold(fates, 2 * max(overhang for overhang, _ in stacks))
