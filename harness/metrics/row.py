"""What goes through a row of equal balls: how much of the momentum the last one carries in the end.

A row is all movable balls of one material, on one line; the first is the one that moves at the start. In a row with gaps each
elastic blow hands everything on, so that the last ball carries all; in a row that touches that is one of many outcomes that
keep momentum and energy.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene, Sphere
from plumbline.harness.trajectory import Floats, Trajectory

SOURCE = "Herrmann, Schmaelzle, Am. J. Phys. 49 (1981) 761 (a row with gaps is a chain of pairs)"
CONTACT = 1e-9
"""Gaps below this [m] are none: the rounding of places of some metres, a million times over."""


def _rows(scene: Scene) -> list[tuple[list[int], Floats, float]]:
    """Of each row: places of the balls from the first to the last, the way of the first, the narrowest gap [m]."""
    kinds: dict[str, list[int]] = {}
    for place, body in enumerate(scene.bodies):
        if body.movable and len(body.collision) == 1 and isinstance(body.collision[0].shape, Sphere):
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
        radii = [
            placed.shape.radius for k in ordered for placed in scene.bodies[k].collision if isinstance(placed.shape, Sphere)
        ]
        gaps = np.diff(along) - np.array(radii[1:]) - np.array(radii[:-1])
        rows.append((ordered, way, float(gaps[1:].min()) if len(gaps) > 1 else float(gaps[0])))
    if not rows:
        raise NotMeasurable("no row of balls of which one moves")
    return rows


def _share(scene: Scene, actual: Trajectory, places: list[int], way: Floats) -> float:
    """The last ball's share of the momentum that the first one brought."""
    if len(actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    first, last = scene.bodies[places[0]], scene.bodies[places[-1]]
    brought = first.mass * float(np.linalg.norm(first.v_WB))
    return last.mass * float(actual.v_WB[-1, places[-1]] @ way) / brought


@metric("1", SOURCE, empty="every row touches")
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
