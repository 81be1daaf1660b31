"""Cams whose round is coarser and coarser: what do facets in place of a ball cost in accuracy, and what do they save in time?

A ball turns evenly about an axis beside its centre, an eccentric cam, and lifts a flat follower on a vertical rail. What the
follower rides on is the ball's support function: its face stands at the ball's highest point, e sin(W t + phase) + r over the
axis. A polyhedron with its corners on the ball holds the face at its highest corner. That lies within the ball of radius r and
never below the top of the largest ball that the polyhedron holds, of radius r cos(c), c being the angle on the ball from the
corners of the largest facet to its middle. So the face is too low by r (1 - cos(c)) at most, about r c^2/2: half the edges, a
quarter of the error. Its speed errs by W r sin(c), of the first order; the blows where facets change do not shrink with them.

Nothing rolls, rubs or rebounds, so that no law of an engine decides. What is left to it, to keep in touch, is judged apart.
Facets are 20, 80, 320, 1280 and 5120 where they are swept, so that edges are halved each time: c is 37 to 2.7 degrees, and the
error 21 mm to .11 mm of a ball of 100 mm, from what anybody sees to less than engines sink under weight.
Source: Rothbart, Cam Design Handbook, 2004 (eccentric cam, flat-faced follower); Ericson, Real-Time Collision Detection,
section 9.5 (supporting points).
"""

import math
from functools import lru_cache
from itertools import combinations

import numpy as np

from plumbline.harness.case import Case, Check, FloatCount, Parameters, Positive
from plumbline.harness.case.bounds import GIVE, G
from plumbline.harness.metrics import errors, overlaps
from plumbline.harness.scene import (
    WORLD,
    Body,
    ConvexHull,
    Effect,
    PlacedShape,
    Prismatic,
    Scene,
    Shape,
    Sphere,
    Surface,
    TriangleMesh,
    sphere_inertia,
)
from plumbline.harness.trajectory import Floats, Integers, Trajectory
from plumbline.harness.trajectory.kinematics import about, rotate

RADIUS, ECCENTRICITY, MASS, SPACING = 0.1, 0.03, 1.0, 0.3
HALF = (0.12, 0.12, 0.02)
"""Half extents of a follower [m]: its face covers every corner that may be the highest one."""
DURATION = math.pi
"""One turn at the cams' own rate [s]."""


class P(Parameters):
    n: FloatCount = 4
    facets: float = 320
    geometry: str = "hull"
    rate: Positive = 2.0
    seed: int = 0


@lru_cache(maxsize=8)
def polyhedron(parts: int) -> tuple[Floats, Integers]:
    """Corners (k, 3) on the unit ball and faces (20 parts^2, 3), counter-clockwise from outside.

    The edges of an icosahedron are cut into so many parts, its faces into small triangles, and all corners pushed out.
    """
    g = (1 + math.sqrt(5)) / 2
    signs = [(one, two * g) for one in (-1.0, 1.0) for two in (-1.0, 1.0)]
    twelve = np.concatenate([np.roll([(0.0, *pair) for pair in signs], k, axis=1) for k in range(3)]) / math.hypot(1.0, g)
    near = twelve @ twelve.T > 0.4
    triples = [t for t in combinations(range(12), 3) if near[t[0], t[1]] and near[t[1], t[2]] and near[t[0], t[2]]]
    numbers: dict[tuple[float, ...], int] = {}
    corners, faces = list[Floats](), []
    for a, b, c in (twelve[list(t)] for t in triples):
        if np.linalg.det([a, b, c]) < 0:
            b, c = c, b
        at = {}
        for i in range(parts + 1):
            for j in range(parts + 1 - i):
                point = ((parts - i - j) * a + i * b + j * c) / parts
                # Edges belong to two of the twenty faces, which differ in rounding.
                at[i, j] = numbers.setdefault(tuple((np.round(point, 9) + 0.0).tolist()), len(numbers))
                corners += [point / np.linalg.norm(point)] * (at[i, j] == len(corners))
        faces += [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in at if i + j < parts]
        faces += [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in at if i + j < parts - 1]
    return np.array(corners), np.array(faces)


@lru_cache(maxsize=8)
def inner(parts: int) -> float:
    """cos(c): radius of the largest ball about the centre that the polyhedron holds, over that of its corners [1]."""
    corners, faces = polyhedron(parts)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return float(np.min(np.einsum("ij,ij->i", normal, a)))


def _parts(facets: float) -> int:
    """Into how many parts edges are cut for about so many facets: 20 parts^2 of them."""
    return max(1, round(math.sqrt(facets / 20)))


def _lost(facets: float, geometry: str) -> float:
    """r (1 - cos(c)): how much lower than on the ball a face may stand [m]."""
    return 0.0 if geometry == "ball" else RADIUS * (1.0 - inner(_parts(facets)))


def _own(dt: float, p: P) -> float:
    """How far from its cam an engine may leave a follower [m]: what contacts that are found once a step cannot see."""
    blow = 0.0 if p.geometry == "ball" else 2 * p.rate * RADIUS * math.sqrt(1.0 - inner(_parts(p.facets)) ** 2)
    return G * dt**2 + blow * dt + GIVE


def _shape(parts: int, geometry: str) -> Shape:
    """The ball, or a polyhedron of it as a hull or as the same facets in a mesh."""
    if geometry == "ball":
        return Sphere(radius=RADIUS)
    corners, faces = polyhedron(parts)
    vertices = tuple((float(x), float(y), float(z)) for x, y, z in RADIUS * corners)
    if geometry == "hull":
        return ConvexHull(vertices=vertices)
    if geometry == "mesh":
        return TriangleMesh(vertices=vertices, faces=tuple((int(a), int(b), int(c)) for a, b, c in faces))
    raise ValueError(f"geometry '{geometry}', expected ball, hull or mesh")


def _top(parts: int, geometry: str, angle: float, q_BS: Floats) -> tuple[float, float]:
    """Height over the axis [m] of the highest point at an angle [rad], and how far along x from the axis [m] it lies."""
    if geometry == "ball":
        return ECCENTRICITY * math.sin(angle) + RADIUS, ECCENTRICITY * math.cos(angle)
    at = np.array([ECCENTRICITY, 0.0, 0.0]) + RADIUS * rotate(q_BS, polyhedron(parts)[0])
    points = rotate(about(1, -np.array(angle)), at)
    highest = points[np.argmax(points[:, 2])]
    return float(highest[2]), float(highest[0])


def _attitudes(n: int, seed: int) -> Floats:
    """How each polyhedron is turned on its cam (n, 4): anyhow, so that each rides over facets of its own."""
    drawn = np.random.default_rng(seed).normal(size=(n, 4))
    turns: Floats = drawn / np.linalg.norm(drawn, axis=1, keepdims=True)
    return turns


def scene(p: P) -> Scene:
    """n cams side by side along y, each ahead of the one before it by 1/n of a turn, with a follower on what it has for a ball.

    The cams turn at `rate` [rad/s]; followers start in touch, at the speed of the point that they touch.
    """
    count, parts = round(p.n), _parts(p.facets)
    bodies, joints = [], []
    for k, q_BS in enumerate(_attitudes(count, p.seed)):
        angle, y = 2 * math.pi * k / count, SPACING * k
        top, along = _top(parts, p.geometry, angle, q_BS)
        cam = PlacedShape(shape=_shape(parts, p.geometry), p_BS=(ECCENTRICITY, 0.0, 0.0), q_BS=tuple(q_BS.tolist()))
        place = (0.0, y, top + HALF[2])
        bodies += [
            Body(
                name=f"cam_{k}",
                motion="kinematic",
                mass=MASS,
                inertia=sphere_inertia(MASS, RADIUS),
                material="cam",
                collision=(cam,),
                p_WB=(0.0, y, 0.0),
                q_WB=tuple(about(1, -np.array(angle)).tolist()),
                w_WB=(0.0, -p.rate, 0.0),
            ),
            Body.box(f"follower_{k}", HALF, mass=MASS, material="follower", p_WB=place, v_WB=(0.0, 0.0, p.rate * along)),
        ]
        joints.append(Prismatic(name=f"rail_{k}", parent=WORLD, child=f"follower_{k}", anchor_W=place, axis_W=(0.0, 0.0, 1.0)))
    return Scene(
        bodies=tuple(bodies),
        joints=tuple(joints),
        surfaces=(Surface(between=("cam", "follower")),),
        apart=(("cam", "cam"), ("follower", "follower")),
        # Nothing that forces move turns.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The ball's: z = e sin(W t + phase) + r for the face of each follower."""
    count = round(p.n)
    truth = Trajectory.of(time, 2 * count)
    for k in range(count):
        angle = 2 * math.pi * k / count + p.rate * truth.time
        truth.p_WB[:, 2 * k : 2 * k + 2, 1] = SPACING * k
        truth.q_WB[:, 2 * k] = about(1, -angle)
        truth.w_WB[:, 2 * k, 1] = -p.rate
        truth.p_WB[:, 2 * k + 1, 2] = ECCENTRICITY * np.sin(angle) + RADIUS + HALF[2]
        truth.v_WB[:, 2 * k + 1, 2] = ECCENTRICITY * p.rate * np.cos(angle)
    return truth


CASE = Case.of(
    globals(),
    title="Coarse collision geometry",
    question="What do facets in place of a round body cost in accuracy, and does an engine add to what geometry alone costs?",
    source="Rothbart, Cam Design Handbook, 2004; Ericson, Real-Time Collision Detection, section 9.5",
    truth="closed form",
    sample_interval=1 / 240,
    checks=(
        Check(
            overlaps.cam_follower_gap,
            _own,
            "before a contact can push, a follower falls for one step, g dt^2; where facets change, the new corner "
            "goes up faster than the old one by 2 W r sin(c) at most, each being W r sin(c) off the ball's own speed, and so "
            "into the face for a step; and a millimetre, which a contact may give way under weight",
            another_truth="the truth is that of the ball, and the gap that to the facets of this scene",
        ),
        Check(
            errors.position_error_max,
            lambda dt, p: _lost(p.facets, p.geometry) + _own(dt, p),
            "r (1 - cos(c)): the highest corner lies in the ball of radius r and over the largest ball that the facets "
            "hold; and what an engine may add, the bound of the gap between cam and follower",
        ),
    ),
    observe=(errors.position_error_rms, errors.velocity_error_max, errors.velocity_error_rms),
    headline=errors.position_error_max.name,
    scale=RADIUS,
)
