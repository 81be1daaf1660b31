"""A-frames of two cards that lean against each other: at which friction of their feet do they stand, and for how long?

Two equal cards of half length l and half thickness c stand at the angle a to the vertical on their lower edges and lean edge to
edge. Each bears its own weight W at its foot; the moments about it ask for a thrust H = W (tan a - c/l)/2 at the top, which
friction at the foot has to balance: the frame stands iff

    mu >= (tan a - c/l)/2

if the cards hold on to each other. A frame is two movable boxes, one after the other in the scene.
Source: Beer, Johnston, Vector Mechanics: Statics, 12th ed., sections 6.3 and 8.1 (frames; dry friction).
"""

import math
from dataclasses import dataclass

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Box, Scene, rotate

SOURCE = "statics of an A-frame: stands iff mu >= (tan a - c/l)/2"


def critical_friction(angle: float, half_length: float, half_thickness: float) -> float:
    """The least friction [1] at the feet of cards at `angle` [rad] to the vertical; half extents [m]."""
    return (math.tan(angle) - half_thickness / half_length) / 2


@dataclass(frozen=True, slots=True)
class _Frame:
    """Friction at the feet over the critical one [1], and the time [s] for which no card sank to half of its height."""

    friction: float
    stood: float


def _friction(scene: Scene, card: Body) -> float:
    for other in scene.bodies:
        if not other.movable and scene.collides(card, other):
            return scene.surface(card, other).static_friction
    raise NotMeasurable(f"body '{card.name}' has nothing to stand on")


def _frames(run: Run) -> list[_Frame]:
    """All frames; a card stands along the z axis of its body, its thickness along x."""
    cards = [place for place, body in enumerate(run.scene.bodies) if body.movable]
    if len(cards) < 2 or len(cards) % 2 or len(run.actual) == 0:
        raise NotMeasurable(f"{len(cards)} cards and {len(run.actual)} samples, expected pairs and at least one")
    frames = []
    for pair in zip(cards[::2], cards[1::2], strict=True):
        card = run.scene.bodies[pair[0]]
        shape = card.collision[0].shape if len(card.collision) == 1 else None
        if not isinstance(shape, Box):
            raise NotMeasurable(f"body '{card.name}' is no single box")
        angle = math.acos(rotate(card.q_WB, (0.0, 0.0, 1.0))[2])
        critical = critical_friction(angle, shape.half_extents[2], shape.half_extents[0])
        start = np.array([run.scene.bodies[i].p_WB[2] for i in pair])
        sunk = np.any(run.actual.p_WB[:, pair, 2] < start / 2, axis=1)
        stood = float(run.actual.time[np.argmax(sunk)] if sunk.any() else math.inf)
        frames.append(_Frame(_friction(run.scene, card) / critical, stood))
    return frames


@metric("1", SOURCE, verdict="a card of a frame sinks below half of its height")
def frame_friction_error(run: Run) -> float:
    """middle between the greatest friction that falls and the least above it that stands, over the critical, less 1"""
    frames = _frames(run)
    # Where all stand the threshold is taken for half of the least friction's; where all fall, for twice the greatest.
    falls = max([0.0, *(frame.friction for frame in frames if math.isfinite(frame.stood))])
    most = 2 * max(frame.friction for frame in frames)
    # What stands with less friction than one that falls is no threshold: a pair of wrong fates would make up for each other.
    stands = min([most, *(frame.friction for frame in frames if math.isinf(frame.stood) and frame.friction > falls)])
    return abs((falls + stands) / 2 - 1)


@metric("s", SOURCE, better="higher", verdict="a card of a frame that has the friction to stand sinks below half of its height")
def frame_standing_time(run: Run) -> float:
    """the least time for which a frame stands that should; the run's length where all do"""
    times = [min(frame.stood, float(run.actual.time[-1])) for frame in _frames(run) if frame.friction >= 1]
    if not times:
        raise NotMeasurable("no frame has the friction to stand")
    return min(times)
