"""Overhang: how far bricks laid on each other reach beyond the edge of a table before they fall.

A stack is a static box, the table, and the movable boxes that follow it in the scene, from the lowest to the highest. Bricks
of length l, each with its end beyond the one below, stand iff the common centre of mass of those above each edge lies inside
of it; n bricks reach at most

    l/2 (1 + 1/2 + ... + 1/n).

Source: Hall, Fun with Stacking Blocks, Am. J. Phys. 73 (2005) 1107; Paterson, Zwick, Overhang, Am. Math. Monthly 116 (2009) 19.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Box, Scene


def harmonic_overhang(n: int) -> float:
    """The greatest overhang of n bricks, one on the other, in lengths of a brick."""
    return sum(1 / k for k in range(1, n + 1)) / 2


def _half_extents(body: Body) -> tuple[float, float, float]:
    if len(body.collision) != 1 or not isinstance(body.collision[0].shape, Box):
        raise NotMeasurable(f"body '{body.name}' is no single box")
    return body.collision[0].shape.half_extents


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
    1"""
    stacks = _stacks(run.scene)
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    # Where all stand the limit is taken for at least twice the longest; where all fall, for half of the shortest. What stands
    # beyond the first that falls is no limit: else short ones that fall and long ones that stand would make up for each other.
    stood, falling = [0.0], 2 * max(overhang for overhang, _ in stacks)
    for overhang, bricks in stacks:
        start = np.array([run.scene.bodies[i].p_WB[2] for i in bricks])
        # A brick has fallen when it has sunk by its own half thickness: what tips over the edge below does.
        thick = np.array([_half_extents(run.scene.bodies[i])[2] for i in bricks])
        if np.any(start - run.actual.p_WB[-1, bricks, 2] > thick):
            falling = min(falling, overhang)
        else:
            stood.append(overhang)
    standing = max(overhang for overhang in stood if overhang < falling)
    return abs((standing + falling) / 2 - 1)
