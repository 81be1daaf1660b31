"""What is to come, read off the start of a scene: how unlike its masses are, how far springs give, how fast bodies move."""

from collections import defaultdict
from collections.abc import Sequence
from math import pi, sqrt

from plumbline.harness.adapter.spanning_forest import DisjointSets
from plumbline.harness.scene import Body, Plane, Scene, TriangleMesh, outer_radius, width

__all__ = ["half_width", "heap_gives_way", "length", "mass_ratio", "quickest_turn", "way_through"]

STEADY = 0.08
"""Share of half a body's width by which springs under a heap may sink, times the number of its bodies. In searches of limits
towers of boxes stood up to .08 to .4 of it and fell from .18 to .7 on, at sub-steps of 1/240 to 1/15 s in two sweeps."""


def length(v: Sequence[float]) -> float:
    """Of a vector (3,), rounded alike by every processor."""
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


def half_width(body: Body) -> float:
    """Half of the least width of a body's shapes [m]; infinite for what bounds no solid."""
    thin = (width(placed.shape) for placed in body.collision if not isinstance(placed.shape, Plane | TriangleMesh))
    return min(thin, default=float("inf")) / 2


def mass_ratio(scene: Scene) -> float:
    """The greatest ratio of the masses of two movable bodies that can touch; 1 where none can."""
    bodies = [body for body in scene.bodies if body.movable]
    pairs = ((a.mass, b.mass) for k, a in enumerate(bodies) for b in bodies[k + 1 :] if scene.collides(a, b))
    return max((max(pair) / min(pair) for pair in pairs), default=1.0)


def heap_gives_way(scene: Scene, substep: float) -> bool:
    """Whether the soft contacts of a sub-step [s] are too soft for what may rest on them.

    Under a body of mass m that bears M they sink by M g/(m w^2), w = pi/2 over the sub-step. A tower of n bodies of half
    width a topples on such springs where the torque of its weight outgrows theirs, M g n a > m w^2 a^2: where n times that
    depth exceeds a. Springs that sweeps have not yet loaded are softer still: see `STEADY`. A lone body, n = 1, merely sinks.
    """
    bodies = [body for body in scene.bodies if body.movable and body.collision]
    heaps, members = DisjointSets[str](), defaultdict[str, list[Body]](list)
    for k, a in enumerate(bodies):
        for b in bodies[k + 1 :]:
            if scene.collides(a, b):
                heaps.unite(a.name, b.name)
    for body in bodies:
        members[heaps.root(body.name)].append(body)
    share = substep / (pi / 2)
    free_fall = length(scene.gravity) * share * share
    return any(
        len(heap) * free_fall * sum(body.mass for body in heap) / min(body.mass for body in heap)
        > STEADY * min(half_width(body) for body in heap)
        for heap in members.values()
    )


def way_through(scene: Scene) -> float:
    """The fastest that two bodies may meet at the start, in widths of the thinnest body [1/s].

    Contacts are made half such a width ahead, and one found half of it deep is still pushed back to where it came from.
    """
    thinnest = min((half_width(body) for body in scene.bodies), default=float("inf"))
    movers = sorted(((_speed(body), body) for body in scene.bodies if body.movable and body.collision), key=lambda m: -m[0])
    fastest = movers[0][0] if movers else 0.0
    for k, (speed, body) in enumerate(movers):
        for other_speed, other in movers[k + 1 :]:
            if speed + other_speed <= fastest:
                break
            if scene.collides(body, other):
                fastest = speed + other_speed
    return fastest / (2 * thinnest)


def quickest_turn(scene: Scene) -> float:
    """The greatest rate of turning of a movable body at the start [rad/s]."""
    return max((length(body.w_WB) for body in scene.bodies if body.movable), default=0.0)


def _speed(body: Body) -> float:
    """Of the fastest point that a turn carries to where the body was not [m/s]."""
    reach = max(length(placed.p_BS) + outer_radius(placed.shape) for placed in body.collision)
    return length(body.v_WB) + length(body.w_WB) * max(0.0, reach - half_width(body))
