"""Rays into a yard of 51 primitives: a scanning range finder or a depth camera, checked against closed forms."""

import math
from dataclasses import replace

import numpy as np

from plumbline.harness.case import Case, Check, FloatCount, Parameters, Rays
from plumbline.harness.case.bounds import SINGLE
from plumbline.harness.metrics.ranges import range_error_max, range_error_median, range_false_return_share
from plumbline.harness.scene import Body, Box, Capsule, Cylinder, Plane, Scene, Shape, Sphere, axis_angle, box_inertia
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.trajectory import Floats, State, Trajectory

SHAPES: tuple[Shape, ...] = (
    Sphere(radius=0.5),
    Box(half_extents=(0.4, 0.3, 0.6)),
    Capsule(radius=0.25, half_length=0.5),
    Cylinder(radius=0.35, half_length=0.7),
)
COUNT, REACH = 50, 30.0
GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))
EYE = (0.0, 0.0, 1.2)
CHANNELS, COLUMNS = 32, 1024
WIDTH, HEIGHT, FOCAL = 640, 480, 500.0
ROUNDING = 8 * SINGLE * REACH


class P(Parameters):
    pattern: str = "lidar"
    thin: FloatCount = 1


def scene(_: P) -> Scene:
    """A floor and fifty solids on a sunflower spiral around the place of the sensor; nothing moves."""
    solids = []
    for k in range(COUNT):
        # Distances grow like the square root of the number: equal area, at least 1.4 m, for each.
        distance, azimuth = 1.5 * math.sqrt(k + 4), k * GOLDEN_ANGLE
        solids.append(
            Body.fixed(
                f"solid_{k}",
                SHAPES[k % len(SHAPES)],
                p_WB=(distance * math.cos(azimuth), distance * math.sin(azimuth), 0.8 + 0.1 * (k % 5)),
                q_WB=axis_angle((math.cos(2.0 * k), math.sin(2.0 * k), 0.3), 0.4 * (k % 7)),
            )
        )
    floor = Body.fixed("floor", Plane())
    carrier = Body(name="carrier", inertia=box_inertia(1.0, (0.1, 0.1, 0.1)), p_WB=EYE)
    return Scene(bodies=(floor, *solids, carrier), gravity=(0.0, 0.0, 0.0))


def directions(pattern: str) -> Floats:
    """Unit directions (r, 3): 'lidar' by channel and column, 'depth' by row and pixel of a camera looking along +x."""
    if pattern == "lidar":
        elevation = np.linspace(-0.45, 0.25, CHANNELS)[:, None]
        azimuth = 2.0 * np.pi * np.arange(COLUMNS)[None, :] / COLUMNS
        across, up = np.cos(elevation), np.broadcast_to(np.sin(elevation), (CHANNELS, COLUMNS))
        return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), up], axis=-1).reshape(-1, 3)
    if pattern != "depth":
        raise ValueError(f"pattern '{pattern}', expected 'lidar' or 'depth'")
    right = (np.arange(WIDTH) + 0.5 - WIDTH / 2) / FOCAL
    down = (np.arange(HEIGHT) + 0.5 - HEIGHT / 2) / FOCAL
    y, z = np.meshgrid(-right, -down)
    ahead = np.stack([np.ones_like(y), y, z], axis=-1).reshape(-1, 3)
    unit: Floats = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    return unit


def rays(p: P) -> Rays:
    """Every `thin`-th ray of the pattern, all from EYE."""
    chosen = np.ascontiguousarray(directions(p.pattern)[:: round(p.thin)])
    return Rays(origins=np.tile(np.array(EYE), (len(chosen), 1)), directions=chosen, max_range=REACH)


def expected(time: Floats, p: P) -> Trajectory:
    """Nothing moves; ranges are the closed-form first hits."""
    stage, cast = scene(p), rays(p)
    start, truth = State.initial(stage), Trajectory.of(time, len(stage.bodies))
    truth.p_WB[:], truth.q_WB[:] = start.p_WB, start.q_WB
    hits = first_hits(stage, start, cast.origins, cast.directions, cast.max_range)
    return replace(truth, streams={"rays/time": np.zeros(1), "rays/range_ideal": hits.distance[None]})


CASE = Case.of(
    globals(),
    title="Rays against primitives",
    question="What does a ray cost, and does it end where geometry says?",
    source="closed-form intersection of rays and primitives (Ericson, Real-Time Collision Detection, section 5.3)",
    truth="closed form",
    duration=0.1,
    sample_interval=0.1,
    # The answer to a ray does not depend on the time step: one is enough.
    ladder=(1 / 240,),
    headline=range_error_max.name,
    checks=(
        Check(
            range_error_median,
            ROUNDING,
            "single precision: eight roundings of the longest range; half of all rays meet their surface less "
            "askew than that enlarges",
        ),
        Check(
            range_false_return_share,
            2 * ROUNDING / (1.0 / FOCAL),
            "a ray may err where it passes an edge within the rounding above; the nearest solids stand 2 m away, "
            "where the closest rays are 2 m/FOCAL apart, so that, were every ray beside an edge, this share would be in doubt",
        ),
    ),
    observe=(range_error_max,),
)
