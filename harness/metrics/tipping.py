"""Boxes on inclines that hold, slide or tip over: is the fate of each what statics says, and at which angle do they tip?

A box of half length b along the fall line and half height h tips about its lower edge iff tan(angle) > b/h, if friction holds
it until then, mu >= b/h; else it slides iff tan(angle) > mu, without tipping.
Source: Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Box, rotate
from plumbline.harness.trajectory.kinematics import rotate as rotate_along

SOURCE = "Meriam, Kraige, Statics, section 6/3: tips iff tan(angle) > b/h before it slides at tan(angle) = mu"
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
    if not g.any() or len(run.actual) == 0 or run.actual.time[-1] <= 0:
        raise NotMeasurable("no gravity or no time to move")
    fates = []
    for place, body in enumerate(run.scene.bodies):
        if not body.movable:
            continue
        shape = body.collision[0].shape if len(body.collision) == 1 else None
        ground = next((b for b in run.scene.bodies if not b.movable and run.scene.collides(body, b)), None)
        if not isinstance(shape, Box) or ground is None:
            raise NotMeasurable(f"body '{body.name}' is no single box on an incline")
        along, normal = (np.array(rotate(body.q_WB, axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        pull, load = float(g @ along), float(-g @ normal)
        slope, tips_at = pull / load, shape.half_extents[0] / shape.half_extents[2]
        mu = run.scene.surface(body, ground).kinetic_friction
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


@metric("1", SOURCE, verdict="a box tilts by half a radian, or slides by half its due way or a tenth of its length")
def wrong_fates(run: Run) -> float:
    """number of boxes that hold, slide or tip (by 0.5 rad) where they should not"""
    return float(sum(fate.found != fate.true for fate in _fates(run)))


@metric("1", SOURCE, verdict="a box tilts by half a radian")
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
    tipped = min([math.pi / 2, *(math.atan(fate.slope) for fate in alike if fate.found == "tips")])
    # What stays upright on a steeper incline than one that tips is no threshold: wrong fates would make up for each other.
    slopes = [math.atan(fate.slope) for fate in alike if fate.found != "tips"]
    upright = max([0.0, *(slope for slope in slopes if slope < tipped)])
    return abs((upright + tipped) / 2 / math.atan(tips_at) - 1)
