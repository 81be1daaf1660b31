"""How deep the bodies of a scene stand in one another along a trajectory, pair by pair, from their poses and shapes."""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from plumbline.harness.scene import PlacedShape, Scene
from plumbline.harness.trajectory import Floats, Integers, Trajectory
from plumbline.harness.trajectory.convex_depth import Convex, Unmeasured, depth, reach, solid
from plumbline.harness.trajectory.kinematics import product, rotate

POSES = 1024
"""Of pairs that are measured in one call: enough to outweigh its start, few enough for the directions of each to fit memory."""


@dataclass(frozen=True, slots=True)
class _Near:
    """Two shapes that come near. Terms: a, b: their numbers. at: the samples at which they are near, (k,)."""

    a: int
    b: int
    at: Integers


def _shapes(scene: Scene) -> list[tuple[int, PlacedShape]]:
    return [(place, placed) for place, body in enumerate(scene.bodies) for placed in body.collision]


def _poses(run: Trajectory, place: int, placed: PlacedShape) -> tuple[Floats, Floats]:
    """Position (t, 3) m and attitude (t, 4) of a shape in W."""
    q_WB = run.q_WB[:, place]
    return run.p_WB[:, place] + rotate(q_WB, np.array(placed.p_BS)), product(q_WB, np.array(placed.q_BS))


def pair_depths(scene: Scene, run: Trajectory) -> Iterator[tuple[int, int, Floats | None]]:
    """Of each two shapes that come near: their bodies' places, and how deep the shapes stand in one another, (t,) m.

    -inf where they are far apart; None of a pair of shapes whose depth is not known exactly.
    """
    shapes = _shapes(scene)
    if not shapes or len(run) == 0:
        return
    p, q = (np.stack(parts, axis=1) for parts in zip(*(_poses(run, place, placed) for place, placed in shapes), strict=True))
    solids = [_solid(placed) for _, placed in shapes]
    for pairs in _together(_near(scene, [place for place, _ in shapes], solids, p)):
        for pair, deep in zip(pairs, _depths(pairs, solids, p, q), strict=True):
            whole = None if deep is None else np.full(len(run), -np.inf)
            if whole is not None:
                whole[pair.at] = deep
            yield shapes[pair.a][0], shapes[pair.b][0], whole


def _near(scene: Scene, places: Sequence[int], solids: Sequence[Convex | None], p: Floats) -> Iterator[_Near]:
    """The pairs of shapes that can touch and come near. Args: places: of their bodies; p: of the shapes, (t, n, 3) m."""
    reaches = np.array([math.inf if hull is None else reach(hull) for hull in solids])
    for a, place in enumerate(places):
        near = np.sum((p[:, :a] - p[:, a : a + 1]) ** 2, axis=2) <= (reaches[:a] + reaches[a]) ** 2
        for b in np.flatnonzero(near.any(axis=0)).tolist():
            if scene.collides(scene.bodies[place], scene.bodies[places[b]]):
                yield _Near(a, b, np.flatnonzero(near[:, b]))


def _together(pairs: Iterable[_Near]) -> Iterator[list[_Near]]:
    """The pairs in their order, as many at once as have `POSES` poses between them."""
    some, poses = list[_Near](), 0
    for pair in pairs:
        some.append(pair)
        poses += len(pair.at)
        if poses >= POSES:
            yield some
            some, poses = [], 0
    if some:
        yield some


def _solid(placed: PlacedShape) -> Convex | None:
    try:
        return solid(placed.shape)
    except Unmeasured:
        return None


def _depths(pairs: Sequence[_Near], solids: Sequence[Convex | None], p: Floats, q: Floats) -> list[Floats | None]:
    """The depth of each pair where it is near, (k,) m; None where it is not known exactly. Equal solids go together."""
    alike: dict[tuple[int, int], list[int]] = {}
    for number, pair in enumerate(pairs):
        # Equal shapes are one solid.
        alike.setdefault((id(solids[pair.a]), id(solids[pair.b])), []).append(number)
    deep: list[Floats | None] = [None] * len(pairs)
    for numbers in alike.values():
        chosen = [pairs[number] for number in numbers]
        a, b = solids[chosen[0].a], solids[chosen[0].b]
        if a is None or b is None:
            continue
        counts, samples = [len(pair.at) for pair in chosen], np.concatenate([pair.at for pair in chosen])
        at_a = samples, np.repeat([pair.a for pair in chosen], counts)
        at_b = samples, np.repeat([pair.b for pair in chosen], counts)
        with suppress(Unmeasured):
            measured = depth(a, p[at_a], q[at_a], b, p[at_b], q[at_b])
            for number, own in zip(numbers, np.split(measured, np.cumsum(counts)[:-1]), strict=True):
                deep[number] = own
    return deep
