"""Balls that fall fast on a thin plate and on a thin slab of triangles, and slide on over the inner edges of its mesh.

Both grounds are level and nothing rubs, so that a ball stops falling and keeps its speed along the ground, whether it lands on
a face, or rolls its way over an edge between two triangles, or along one. Where a ball arrives in a step decides whether a
discrete test sees the ground, so that every ball falls for its own random time, uniform over 1/60 s.
Source: Ericson, Real-Time Collision Detection, section 2.4.3; Bullet, btInternalEdgeUtility.h (the fault at inner edges
by name).
"""

import math

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Count, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import passage
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface, TriangleMesh
from plumbline.harness.trajectory import Floats, Trajectory

SLIDE, PHASES = 1.0, 32
RADIUS, MASS, CELL = 0.05, 1.0, 0.25
FALL, DURATION = 0.02, 0.5
ALONG = (-1, 4)
"""The first and last corner of the grounds along x, in cells: balls start in cell 0 and slide for two."""
OFF_EDGE = 0.37
"""How far beside an edge every other ball runs, in cells: on no corner, inner edge or diagonal."""


class P(Parameters):
    speed: Positive = 20.0
    slide: float = SLIDE
    phases: Count = PHASES
    thickness: Positive = 0.01
    continuous: bool = True
    seed: int = 0


def _slab(rows: int, thickness: float) -> TriangleMesh:
    """A closed slab with its top at z = 0, both its sides in square cells of CELL [m], each cut along a diagonal."""
    columns = ALONG[1] - ALONG[0]
    nx, ny = columns + 1, rows + 1
    corners = [(CELL * (i + ALONG[0]), CELL * (j - 1), z) for z in (0.0, -thickness) for j in range(ny) for i in range(nx)]
    faces = []
    for j in range(rows):
        for i in range(columns):
            a, b, c, d = i + j * nx, i + 1 + j * nx, i + 1 + (j + 1) * nx, i + (j + 1) * nx
            faces += [(a, b, c), (a, c, d)]
            faces += [(k + nx * ny, m + nx * ny, n + nx * ny) for k, m, n in ((a, c, b), (a, d, c))]
    rim = [*range(columns)] + [columns + j * nx for j in range(rows)]
    rim += [i + rows * nx for i in range(columns, 0, -1)] + [j * nx for j in range(rows, 0, -1)]
    for a, b in zip(rim, rim[1:] + rim[:1], strict=True):
        faces += [(a, a + nx * ny, b + nx * ny), (a, b + nx * ny, b)]
    return TriangleMesh(vertices=tuple(corners), faces=tuple(faces))


def _falls(phases: int, seed: int) -> Floats:
    """Times (2 phases,) s at which the balls land: first those over the plate, then those over the mesh."""
    return FALL + np.random.default_rng(seed).uniform(0.0, 1 / 60, 2 * phases)


def scene(p: P) -> Scene:
    """`phases` balls over each of two grounds `thickness` [m] thick, falling at `speed` and going along x at `slide` [m/s].

    Over the mesh every other ball goes right along a line of inner edges. `continuous` calls for continuous collision
    detection; an engine that lacks it, or leaves it off by default, runs without and says so, and with False every engine
    gives what its plain contacts give.
    """
    rows = p.phases + 2
    width = CELL * rows
    draw = np.random.default_rng((p.seed, 1))
    balls = []
    for i, fall in enumerate(_falls(p.phases, p.seed)):
        row, over_mesh = i % p.phases, i >= p.phases
        y = CELL * (row + (OFF_EDGE if row % 2 else 0.0)) + (2 * width if over_mesh else 0.0)
        height = p.speed * float(fall) + G * float(fall) ** 2 / 2
        balls.append(
            Body.ball(
                f"ball_{i}",
                RADIUS,
                mass=MASS,
                material="ball",
                p_WB=(float(draw.uniform(0.0, CELL)), y, RADIUS + height),
                v_WB=(p.slide, 0.0, -p.speed),
            )
        )
    half_x, middle_x = CELL * (ALONG[1] - ALONG[0]) / 2, CELL * (ALONG[1] + ALONG[0]) / 2
    plate = Body.fixed(
        "plate",
        Box(half_extents=(half_x, width / 2, p.thickness / 2)),
        material="ground",
        p_WB=(middle_x, width / 2 - CELL, -p.thickness / 2),
    )
    mesh = Body.fixed("mesh", _slab(rows, p.thickness), material="ground", p_WB=(0.0, 2 * width, 0.0))
    return Scene(
        bodies=(plate, mesh, *balls),
        surfaces=(Surface(between=("ball", "ground")),),
        apart=(("ball", "ball"),),
        widen=Effect.CONTINUOUS_COLLISION if p.continuous else Effect.NONE,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: free fall until the ground, then an even slide on it."""
    truth = Trajectory.at_rest(scene(p), time)
    for place, fall in enumerate(_falls(p.phases, p.seed), start=2):
        falling = np.minimum(truth.time, fall)
        truth.p_WB[:, place, 0] += p.slide * truth.time
        truth.p_WB[:, place, 2] -= p.speed * falling + G * falling**2 / 2
        truth.v_WB[:, place, 0] = p.slide
        truth.v_WB[:, place, 2] = np.where(truth.time < fall, -p.speed - G * truth.time, 0.0)
    return truth


CASE = Case.of(
    globals(),
    title="Balls on a thin plate and a thin mesh",
    question="Does a fast ball fall through a thin plate or mesh, and do inner edges kick a ball that slides over them?",
    source="Ericson, Real-Time Collision Detection, section 2.4.3; Bullet, btInternalEdgeUtility.h",
    truth="closed form",
    hard=Axis(parameter="speed", unit="m/s", easy=1, extreme=300, lost=0.0),
    checks=(
        Check(
            passage.passage_probability,
            0.0,
            "a ground lets no ball through, at any phase: no centre ends below its middle; 0 of 64 put the probability "
            "under 5.7 % (Wilson, 95 %)",
        ),
        Check(
            passage.lateral_kick,
            lambda _, p: 1e-6 * math.hypot(p.speed, p.slide),
            "level ground without friction has no force along it, inner edge or not; 1e-6 of the speed for single precision",
        ),
        Check(
            passage.rest_speed,
            lambda dt, _: G * dt,
            "a ball at rest on the ground is given g dt by gravity in each step before the ground takes it away",
        ),
    ),
    observe=(passage.passage_probability_low, passage.passage_probability_high, passage.sink_depth),
)
