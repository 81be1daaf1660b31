"""Bodies in one another's place, from poses and shapes alone: those that should be kept apart or in, stay on, or meet.

An engine's own report of contacts may be cut short or hold margins; positions cannot. The ball inscribed in a convex shape
about its centre lies inside it however the shape turns, so that two of them that overlap, or one that reaches into a half space
at rest, prove that the bodies do. It is less than the true depth.

A ring that a post goes through holds the post in the place of its own centre of mass. While neither breaks or passes through
the other, it can leave over the post's end alone.
"""

import math
from collections.abc import Iterator

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import (
    Body,
    Box,
    ConvexHull,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    TriangleMesh,
    rotation_matrix,
    width,
)
from plumbline.harness.scene.shape import support
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import movable, rotate, rotate_back


def _balls(scene: Scene) -> tuple[list[int], Floats]:
    """Places and radii [m] of the movable bodies, each a single ball about its centre of mass."""
    places = movable(scene).tolist()
    radii: list[float] = []
    for place in places:
        shapes = scene.bodies[place].collision
        if len(shapes) != 1 or not isinstance(shapes[0].shape, Sphere) or any(shapes[0].p_BS):
            raise NotMeasurable(f"body '{scene.bodies[place].name}' is no single ball about its centre of mass")
        radii.append(shapes[0].shape.radius)
    if not places:
        raise NotMeasurable("no body can move")
    return places, np.array(radii)


def _planes(scene: Scene) -> Iterator[tuple[Floats, Floats]]:
    """A point [m] and the outward normal of each plane that stands still."""
    for body in scene.bodies:
        for placed in () if body.movable else body.collision:
            if body.motion != "static" or not isinstance(placed.shape, Plane):
                raise NotMeasurable(f"body '{body.name}' is no plane that stands still")
            q_WB = np.array(body.q_WB)
            normal = rotate(q_WB, rotate(np.array(placed.q_BS), np.array(placed.shape.normal)))
            yield np.array(body.p_WB) + rotate(q_WB, np.array(placed.p_BS)), normal


@metric("m")
def overlap(run: Run) -> float:
    """impenetrability: greatest r_i + r_j - |p_i - p_j| of two balls, and r - n . (p - p_plane) of a ball and a plane"""
    from scipy.spatial import cKDTree  # late: a listing must not pay for it

    places, radii = _balls(run.scene)
    planes = list(_planes(run.scene))
    deepest, reach = 0.0, 2.0 * float(radii.max())
    for centres in run.actual.p_WB[:, places]:
        pairs = cKDTree(centres).query_pairs(reach, output_type="ndarray")
        if len(pairs):
            apart = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1)
            deepest = max(deepest, float(np.max(radii[pairs[:, 0]] + radii[pairs[:, 1]] - apart)))
        for point, normal in planes:
            deepest = max(deepest, float(np.max(radii - (centres - point) @ normal)))
    return deepest


def _inscribed(body: Body) -> float | None:
    """Radius [m] of the ball about the centre of mass that the body's only shape holds; None for other bodies."""
    if len(body.collision) != 1 or any(body.collision[0].p_BS):
        return None
    shape = body.collision[0].shape
    return None if isinstance(shape, Plane | ConvexHull | TriangleMesh) else width(shape) / 2


@metric("m")
def inscribed_overlap(run: Run) -> float:
    """definition: greatest overlap, at any sample, of the balls inscribed in two bodies that can touch; 0 where none"""
    radii = [_inscribed(body) for body in run.bodies]
    deepest, pairs = -np.inf, 0
    for a, r_a in enumerate(radii):
        for b in range(a + 1, len(radii)):
            r_b = radii[b]
            if r_a is None or r_b is None or not run.scene.collides(run.bodies[a], run.bodies[b]):
                continue
            pairs += 1
            distance = np.linalg.norm(run.actual.p_WB[:, a] - run.actual.p_WB[:, b], axis=-1)
            deepest = np.maximum(deepest, np.max(r_a + r_b - distance))
        for b, other in enumerate(run.bodies):
            if r_a is None or other.motion != "static" or not run.scene.collides(run.bodies[a], other):
                continue
            for placed in other.collision:
                if isinstance(placed.shape, Plane):
                    normal = rotate(np.array(other.q_WB), rotate(np.array(placed.q_BS), np.array(placed.shape.normal)))
                    within = run.actual.p_WB[:, b] + rotate(np.array(other.q_WB), np.array(placed.p_BS))
                    pairs += 1
                    deepest = np.maximum(deepest, np.max(r_a - (run.actual.p_WB[:, a] - within) @ normal))
    if pairs == 0:
        raise NotMeasurable("no two bodies of one convex shape can touch")
    return float(np.maximum(deepest, 0.0))


def _container(scene: Scene) -> tuple[int, Floats]:
    """Place of the body of at least six boxes, and the half extents (3,) m of the box that bounds them all, in B."""
    for place, body in enumerate(scene.bodies):
        if len(body.collision) >= 6 and all(isinstance(placed.shape, Box) for placed in body.collision):
            reach = np.zeros(3)
            for placed in body.collision:
                assert isinstance(placed.shape, Box)
                turned = np.abs(np.array(rotation_matrix(placed.q_BS)))
                reach = np.maximum(reach, np.abs(np.array(placed.p_BS)) + turned @ np.array(placed.shape.half_extents))
            return place, reach
    raise NotMeasurable("no container: a body of at least six boxes")


@metric("1", verdict="a centre ends outside the outer faces of the walls")
def escaped_share(run: Run) -> float:
    """definition: share of spheres whose centre ends outside the box that bounds the container's walls"""
    place, reach = _container(run.scene)
    kept = [
        i
        for i in run.movable
        if i != place and run.bodies[i].collision and all(isinstance(p.shape, Sphere) for p in run.bodies[i].collision)
    ]
    if not kept:
        raise NotMeasurable("no sphere is contained")
    away = run.actual.p_WB[-1, kept] - run.actual.p_WB[-1, place]
    inside = rotate_back(np.broadcast_to(run.actual.q_WB[-1, place], (len(kept), 4)), away)
    return float(np.mean((np.abs(inside) > reach).any(axis=1)))


@metric("1", contacts=True, better="higher", verdict="two bodies overlap in a point or push each other")
def pairs_met(run: Run) -> float:
    """definition: pairs of bodies with a point of contact, at some sample, that overlaps or carries a force"""
    met = set()
    for contacts in run.contacts:
        # Engines list pairs that are near too; those neither overlap nor push.
        touch = (contacts.gap <= 0) | (np.linalg.norm(contacts.force_W, axis=1) > 0)
        pairs = np.sort(np.stack([contacts.body_A, contacts.body_B], axis=1)[touch], axis=1)
        met |= {(int(a), int(b)) for a, b in pairs}
    return float(len(met))


@metric("m/s", verdict="a centre rises over where the truth has it at rest")
def ejection_speed(run: Run) -> float:
    """energy of a throw: sqrt(2 g h) of the greatest height h of a centre of mass over where the truth has it at rest"""
    truth, places = run.truth, run.movable
    pull = np.array(run.scene.gravity)
    g = float(np.linalg.norm(pull))
    if len(places) == 0 or g == 0:
        raise NotMeasurable("no movable body, or no gravity to turn a speed into a height")
    rise = -(run.actual.p_WB[:, places] - truth.p_WB[:, places]) @ pull / g
    return math.sqrt(2 * g * max(0.0, float(np.max(rise))))


def _outside(placed: PlacedShape, points_B: Floats) -> Floats:
    """The distance (t,) m of points (t, 3) in B from a box of the body; 0 within it."""
    assert isinstance(placed.shape, Box)
    points_S = rotate_back(np.array(placed.q_BS), points_B - np.array(placed.p_BS))
    away: Floats = np.linalg.norm(np.maximum(np.abs(points_S) - np.array(placed.shape.half_extents), 0.0), axis=-1)
    return away


@metric("m", verdict="a ring that a post goes through comes off it sideways, which no solid ring can")
def unthreaded(run: Run) -> float:
    """topology: greatest distance of a ring's centre of mass from the box that the ring was put over, 0 while within"""
    farthest, threaded = 0.0, 0
    for place, ring in enumerate(run.bodies):
        for other, holder in enumerate(run.bodies):
            if other == place or not ring.movable or not run.scene.collides(ring, holder):
                continue
            start = rotate_back(np.array(holder.q_WB), np.array(ring.p_WB) - np.array(holder.p_WB))
            for placed in holder.collision:
                if isinstance(placed.shape, Box) and _outside(placed, start[None])[0] == 0.0:
                    threaded += 1
                    path = rotate_back(run.actual.q_WB[:, other], run.actual.p_WB[:, place] - run.actual.p_WB[:, other])
                    farthest = max(farthest, float(np.max(_outside(placed, path))))
    if not threaded:
        raise NotMeasurable("no body is put over a box of another: no centre of mass lies in one at the start")
    return farthest


def _outermost(body: Body, up_B: Floats) -> Floats:
    """The support function of a body: how far from its origin it reaches along directions (t, 3) in B, (t,) m."""
    if not body.collision or any(isinstance(placed.shape, Plane) for placed in body.collision):
        raise NotMeasurable(f"body '{body.name}' has no shape, or one without end")
    outermost: Floats = np.max(
        [up_B @ np.array(p.p_BS) + support(p.shape, rotate_back(np.array(p.q_BS), up_B)) for p in body.collision], axis=0
    )
    return outermost


@metric("m")
def cam_follower_gap(run: Run) -> float:
    """definition: greatest distance, or depth, between the highest point of a cam and the lowest of the follower on it, along
    its rail"""
    places = {body.name: place for place, body in enumerate(run.bodies)}
    cams = [number for number, body in enumerate(run.bodies) if body.motion == "kinematic"]
    rails = [joint for joint in run.scene.joints if joint.type == "prismatic"]
    if not cams or not rails:
        raise NotMeasurable(f"{len(cams)} cams, {len(rails)} followers on rails, expected some of each")
    worst = 0.0
    for rail in rails:
        follower, up = places[rail.child], np.array(rail.axis_W)
        # Each rides on the cam that its rail leads to.
        off = [np.linalg.norm(np.cross(np.array(run.bodies[cam].p_WB) - rail.anchor_W, up)) for cam in cams]
        cam = cams[int(np.argmin(off))]
        ways = [
            rotate_back(run.actual.q_WB[:, place], np.broadcast_to(way, (len(run.actual), 3)))
            for place, way in ((cam, up), (follower, -up))
        ]
        apart = (run.actual.p_WB[:, follower] - run.actual.p_WB[:, cam]) @ up
        gap = apart - _outermost(run.bodies[cam], ways[0]) - _outermost(run.bodies[follower], ways[1])
        worst = max(worst, float(np.max(np.abs(gap))))
    return worst
