"""Nuts and bolts in a bowl: do bodies that are not convex come to rest and stay so, and does a ring stay on its post?

The bowl is a floor with eight walls that lean outwards and a square post in its middle. Two square nuts start around the
post, one above the other; bolts and more nuts, each turned anyhow, fall beside it. Bodies are unions of boxes or, for engines
that move meshes, the same solids as one closed mesh each. An engine that takes a nut for its hull finds the post within it and
throws it off. Where such a heap comes to lie is chance. That it comes to rest and lies still for ten seconds, that the bowl
bears it, that it gains no energy on the way, and that a ring leaves its post over the top alone, is not.
"""

import math

import numpy as np

from plumbline.harness.case import Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, bears, settled_speed, supported
from plumbline.harness.metrics import conservation, contacts, jitter, overlaps
from plumbline.harness.scene import (
    Body,
    Box,
    PlacedShape,
    Scene,
    Shape,
    Surface,
    TriangleMesh,
    Vector3,
    axis_angle,
    box_inertia,
    multiply,
    rotate,
)
from plumbline.harness.trajectory import Floats

RINGS = 2
DENSITY = 7850.0
"""Steel [kg/m3]."""
FLATS, BORE, THICK = 0.05, 0.03, 0.02
"""Half widths of a nut and of its hole, and half its height [m]."""
HEAD, NECK, SHANK = 0.015, 0.025, 0.07
"""Half the height of a bolt's head, which is as wide as a nut; half the width and half the length of its shank [m]."""
POST, TOP, GAP = 0.025, 0.2, 0.005
"""Half the width and the height of the post; free way from a nut on it to what is below [m]."""
FLOOR, LEAN, SLOPE, WALL = 0.2, math.pi / 4, 0.5, 0.05
"""Half the width of the floor [m], lean [rad] and length [m] of the walls, half the thickness of both [m]."""
OUT, HEIGHT, LAYER, RISE = 0.16, 0.13, 4, 0.24
"""Where loose bodies start: off the axis and over the floor [m], so many in a layer, and from one layer to the next [m]."""
SETTLED, DURATION = 4.0, 14.0
SHARE = 0.01
"""Of g, that what lies still may shake by: the noise of a consumer accelerometer (300 micro-g/sqrt(Hz) over 1 kHz)."""


class P(Parameters):
    n: FloatCount = 3
    friction: NotNegative = 0.5
    form: str = "pieces"
    seed: int = 0


def _block(half: Vector3, centre: Vector3) -> PlacedShape:
    return PlacedShape(shape=Box(half_extents=half), p_BS=centre)


def _bowl() -> tuple[PlacedShape, ...]:
    """Floor, post and walls. Each wall lies behind the plane of its inner side, so that none sticks out of another's."""
    walls = []
    for k in range(8):
        q_BS = multiply(axis_angle((0.0, 0.0, 1.0), k * math.pi / 4), axis_angle((0.0, 1.0, 0.0), -LEAN))
        # From the middle of the floor's edge up along the slope, and outwards by half the thickness.
        edge = rotate(axis_angle((0.0, 0.0, 1.0), k * math.pi / 4), (FLOOR, 0.0, 0.0))
        middle = rotate(q_BS, (SLOPE / 2 - WALL, 0.0, -WALL))
        centre = (edge[0] + middle[0], edge[1] + middle[1], edge[2] + middle[2])
        walls.append(PlacedShape(shape=Box(half_extents=(SLOPE / 2, SLOPE / 2, WALL)), p_BS=centre, q_BS=q_BS))
    floor = _block((2 * FLOOR, 2 * FLOOR, WALL), (0.0, 0.0, -WALL))
    return (floor, _block((POST, POST, TOP / 2), (0.0, 0.0, TOP / 2)), *walls)


def _nut() -> tuple[float, Floats, tuple[PlacedShape, ...]]:
    """Mass [kg], inertia [kg m2] and pieces, in a frame at the centre of mass: a square plate about z less its square hole."""
    solid, hole = (DENSITY * 8 * half**2 * THICK for half in (FLATS, BORE))
    inertia = np.array(box_inertia(solid, (FLATS, FLATS, THICK))) - np.array(box_inertia(hole, (BORE, BORE, THICK)))
    side, out = (FLATS - BORE) / 2, (FLATS + BORE) / 2
    across = [_block((side, FLATS, THICK), (sign * out, 0.0, 0.0)) for sign in (-1.0, 1.0)]
    between = [_block((BORE, side, THICK), (0.0, sign * out, 0.0)) for sign in (-1.0, 1.0)]
    return solid - hole, inertia, (*across, *between)


def _bolt() -> tuple[float, Floats, tuple[PlacedShape, ...]]:
    """The same of a bolt, its head below: two boxes, each about the common centre by the parallel-axis theorem."""
    halves = ((FLATS, FLATS, HEAD), (NECK, NECK, SHANK))
    masses = [DENSITY * 8 * a * b * c for a, b, c in halves]
    heights = np.array([HEAD, 2 * HEAD + SHANK])
    heights = heights - np.dot(masses, heights) / sum(masses)
    inertia = np.zeros((3, 3))
    for mass, half, z in zip(masses, halves, heights, strict=True):
        inertia += np.array(box_inertia(mass, half)) + mass * z**2 * np.diag([1.0, 1.0, 0.0])
    return sum(masses), inertia, tuple(_block(half, (0.0, 0.0, float(z))) for half, z in zip(halves, heights, strict=True))


def _skin(pieces: tuple[PlacedShape, ...]) -> TriangleMesh:
    """The surface of a union of boxes along the axes that touch face to face, without what lies inside, by its coordinates."""
    boxes = [(np.array(p.p_BS) - p.shape.half_extents, np.array(p.p_BS) + p.shape.half_extents) for p in pieces]  # type: ignore[union-attr]
    planes = [np.unique(np.round([corner[axis] for pair in boxes for corner in pair], 12)) for axis in range(3)]
    cells = np.zeros([len(at) + 1 for at in planes], dtype=bool)
    for low, high in boxes:
        span = [np.searchsorted(planes[axis], np.round((low[axis], high[axis]), 12)) + 1 for axis in range(3)]
        cells[tuple(slice(*pair) for pair in span)] = True
    numbers: dict[tuple[int, int, int], int] = {}
    faces: list[tuple[int, int, int]] = []
    for cell in np.argwhere(cells):
        for axis in range(3):
            for side in (-1, 1):
                beside = cell.copy()
                beside[axis] += side
                if cells[tuple(beside)]:
                    continue
                one, two = (axis + 1) % 3, (axis + 2) % 3
                corner = cell - 1
                corner[axis] += side > 0
                ring = []
                for along in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    place = corner.copy()
                    place[one] += along[0]
                    place[two] += along[1]
                    ring.append(numbers.setdefault((int(place[0]), int(place[1]), int(place[2])), len(numbers)))
                a, b, c, d = ring if side > 0 else ring[::-1]
                faces += [(a, b, c), (a, c, d)]
    vertices = tuple((float(planes[0][i]), float(planes[1][j]), float(planes[2][k])) for i, j, k in numbers)
    return TriangleMesh(vertices=vertices, faces=tuple(faces))


def _shapes(pieces: tuple[PlacedShape, ...], form: str) -> tuple[PlacedShape, ...]:
    if form == "pieces":
        return pieces
    if form == "mesh":
        shape: Shape = _skin(pieces)
        return (PlacedShape(shape=shape),)
    raise ValueError(f"form '{form}', expected pieces or mesh")


def scene(p: P) -> Scene:
    """The bowl, nuts around its post, and n bolts and nuts by turns in layers over the floor, each turned anyhow."""
    draw, bodies = np.random.default_rng(p.seed), []
    for k in range(RINGS + round(p.n)):
        number, loose = k - RINGS, k >= RINGS
        mass, inertia, pieces = _bolt() if loose and number % 2 == 0 else _nut()
        place, attitude = (0.0, 0.0, (k + 1) * GAP + (2 * k + 1) * THICK), np.array([1.0, 0.0, 0.0, 0.0])
        if loose:
            angle, layer = 2 * math.pi * (number % LAYER + 0.5 * (number // LAYER)) / LAYER, number // LAYER
            place = (OUT * math.cos(angle), OUT * math.sin(angle), HEIGHT + RISE * layer)
            attitude = draw.normal(size=4)
        bodies.append(
            Body(
                name=f"{'loose' if loose else 'ring'}_{k}",
                mass=mass,
                inertia=tuple(tuple(float(x) for x in row) for row in inertia),  # type: ignore[arg-type]
                material="steel",
                collision=_shapes(pieces, p.form),
                p_WB=place,
                q_WB=tuple((attitude / np.linalg.norm(attitude)).tolist()),
            )
        )
    bowl = Body(name="bowl", motion="static", material="steel", collision=_bowl())
    law = Surface.rough(p.friction, ("steel", "steel"))
    return Scene(bodies=(bowl, *bodies), surfaces=(law,))


def _given_back(dt: float, p: P) -> float:
    """Energy over mass that contacts may give back [J/kg]."""
    highest = HEIGHT + RISE * (max(0, round(p.n) - 1) // LAYER)
    return math.exp(-4) * G * highest + (G * dt) ** 2 / 2 + G * GIVE


CASE = Case.of(
    globals(),
    title="Nuts and bolts in a bowl",
    question="Do nuts and bolts in a bowl come to rest and stay so, and does a nut stay on the post that it was put over?",
    source="dissipation: friction and inelastic impacts take what motion there is; topology: a ring leaves a post over its end",
    truth="conservation",
    ladder=(1 / 120, 1 / 240, 1 / 480, 1 / 960),
    sample_interval=1 / 20,
    checks=(
        Check(
            overlaps.unthreaded,
            0.0,
            "a nut moves by 5 mm each way before its hole meets the post, whose sides its centre would pass after 25 "
            "mm; over the top nothing lifts it",
        ),
        bears("a body", SETTLED),
        settled_speed(SETTLED),
        Check(
            jitter.rms_spin,
            lambda dt, _: G * dt / FLATS,
            "g dt, what one step of gravity gives a body before its supports take it away, at the edge of a nut",
            start=SETTLED,
        ),
        Check(
            jitter.rest_drift,
            lambda dt, _: SHARE * G * dt * (DURATION - SETTLED),
            "the speed of 0.01 g, the noise of a consumer accelerometer, over one step, kept up in one direction for "
            "the whole window",
            start=SETTLED,
        ),
        supported(SETTLED, DURATION),
        Check(
            conservation.energy_rise_max,
            _given_back,
            "exp(-4) of the energy of a fall from the highest start: a contact gives back nothing, or, where it is a "
            "critically damped spring that cannot pull, exp(-2) of the speed of a blow; half the square of g dt, one step of "
            "gravity; and g times a millimetre, by which contacts may give way and come back",
        ),
        Check(
            conservation.energy_rise_max,
            lambda dt, _: 1.5 * (G * dt) ** 2,
            "at rest, half the square of g dt, one step of gravity, and g times its way g dt^2",
            start=SETTLED,
        ),
    ),
    headline=contacts.penetration.name,
    scale=THICK,
)
