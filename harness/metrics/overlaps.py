"""Bodies in one another's place: those that should be kept apart or in, and those that should meet.

Overlap: how deep balls stand in one another and in the planes that hold them, from poses alone.

An engine's own report of contacts may be cut short or hold margins; positions cannot.

Overlap of inscribed balls: bodies that pass through each other betray themselves by their places alone.

The ball inscribed in a convex shape about its centre lies inside it however it turns, so that two of them that overlap, or one
that reaches into a half space at rest, prove that the bodies do. It is less than the true depth, and needs no word from the
engine's own contacts.

Containment: how many of the spheres in a hollow box of walls got out of it.

Meetings: how many pairs of bodies ever touched, so that what is asked of blows is not answered by bodies that passed by.

Ejection: the speed with which bodies that started in one another part.
"""

import math
from collections.abc import Iterator

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Body, Box, ConvexHull, Plane, Scene, Sphere, TriangleMesh, rotation_matrix, width
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate, rotate_back


def _balls(scene: Scene) -> tuple[list[int], Floats]:
    """Places and radii [m] of the movable bodies, each a single ball about its centre of mass."""
    places = [place for place, body in enumerate(scene.bodies) if body.movable]
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
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
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
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    radii = [_inscribed(body) for body in run.scene.bodies]
    deepest, pairs = -np.inf, 0
    for a, r_a in enumerate(radii):
        for b in range(a + 1, len(radii)):
            r_b = radii[b]
            if r_a is None or r_b is None or not run.scene.collides(run.scene.bodies[a], run.scene.bodies[b]):
                continue
            pairs += 1
            distance = np.linalg.norm(run.actual.p_WB[:, a] - run.actual.p_WB[:, b], axis=-1)
            deepest = np.maximum(deepest, np.max(r_a + r_b - distance))
        for b, other in enumerate(run.scene.bodies):
            if r_a is None or other.motion != "static" or not run.scene.collides(run.scene.bodies[a], other):
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
        if i != place
        and run.scene.bodies[i].collision
        and all(isinstance(p.shape, Sphere) for p in run.scene.bodies[i].collision)
    ]
    if not kept or len(run.actual) == 0:
        raise NotMeasurable("no sphere is contained, or no sample lies in the time that is judged")
    away = run.actual.p_WB[-1, kept] - run.actual.p_WB[-1, place]
    inside = rotate_back(np.broadcast_to(run.actual.q_WB[-1, place], (len(kept), 4)), away)
    return float(np.mean((np.abs(inside) > reach).any(axis=1)))


@metric("1", better="higher", verdict="two bodies overlap in a point or push each other")
def pairs_met(run: Run) -> float:
    """definition: pairs of bodies with a point of contact, at some sample, that overlaps or carries a force"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    met = set()
    for contacts in run.actual.contacts:
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
    if len(places) == 0 or len(run.actual) == 0 or g == 0:
        raise NotMeasurable("no movable body, no samples or no gravity to turn a speed into a height")
    rise = -(run.actual.p_WB[:, places] - truth.p_WB[:, places]) @ pull / g
    return math.sqrt(2 * g * max(0.0, float(np.max(rise))))
