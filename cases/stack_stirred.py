"""A heap of balls and cubes, stirred by random forces and then left alone: does it come to rest, all in its container?

What has been stirred lies in no packing that anybody chose: contacts come and go, bodies are wedged, some hang on one edge.
"""

import numpy as np

from plumbline.harness.case import Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import settles_from_most_starts
from plumbline.harness.case.forces import Control
from plumbline.harness.case.symmetries import Retelling, other_starts
from plumbline.harness.metrics import jitter, overlaps
from plumbline.harness.props.robots.container import container
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Sphere, Surface, box_inertia, sphere_inertia
from plumbline.harness.trajectory import Floats, State

EDGE, MASS, HALF = 3, 1.0, 0.05
ROOM = 1.3
"""Width of the container over that of EDGE bodies side by side."""
INTERVAL, STIRRED, SETTLED, DURATION = 1 / 60, 3.0, 9.0, 10.0
PUSH, TWIST = 15.0, 0.15
"""Standard deviations of each component of the forces [N], one and a half weights, and of the torques [N m]."""


class P(Parameters):
    n: FloatCount = 18
    friction: NotNegative = 0.5
    seed: int = 0


def scene(p: P) -> Scene:
    """n cubes and balls by turns, in layers of EDGE by EDGE, between four walls on a floor."""
    half = (HALF, HALF, HALF)
    bodies = []
    for k in range(round(p.n)):
        layer, cell = divmod(k, EDGE * EDGE)
        x, y = ((2 * ROOM * HALF) * (index - (EDGE - 1) / 2) for index in divmod(cell, EDGE))
        cube = k % 2 == 0
        bodies.append(
            Body(
                name=f"{'cube' if cube else 'ball'}_{k}",
                mass=MASS,
                inertia=box_inertia(MASS, half) if cube else sphere_inertia(MASS, HALF),
                collision=(PlacedShape(shape=Box(half_extents=half) if cube else Sphere(radius=HALF)),),
                material="stone",
                p_WB=(x, y, HALF * (1 + 2.1 * layer)),
            )
        )
    laws = tuple(Surface.rough(p.friction, pair) for pair in (("stone", "stone"), ("stone", "wall")))
    return Scene(bodies=(*container(ROOM * EDGE * HALF, "wall"), *bodies), surfaces=laws)


def control(p: P) -> Control:
    """Random forces until STIRRED, each held for a sixtieth of a second; none after it."""

    def wrench(time: float, _state: State) -> tuple[Floats, Floats]:
        drawn = np.zeros((5 + round(p.n), 2, 3))
        if time < STIRRED - INTERVAL / 2:
            drawn[5:] = np.random.default_rng((p.seed, round(time / INTERVAL))).standard_normal((round(p.n), 2, 3))
        return PUSH * drawn[:, 0], TWIST * drawn[:, 1]

    return Control(wrench=wrench, interval=INTERVAL)


def retellings(p: P) -> tuple[Retelling, ...]:
    """Where a heap comes to rest hangs on its last bits."""
    return other_starts(scene(p), control(p))


CASE = Case.of(
    globals(),
    title="A heap stirred and left",
    question="Does a heap of balls and cubes that was stirred come to rest, whole and in its container?",
    source="dissipation: once nothing stirs, friction and inelastic impacts take what motion there is",
    truth="conservation",
    ladder=(1 / 60, 1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 960),
    checks=(
        Check(
            overlaps.inscribed_overlap,
            HALF,
            "the definition of broken: half the thinnest body; what left the container is deeper than that in a wall",
        ),
        settles_from_most_starts(SETTLED, "heaps that come to rest"),
    ),
    observe=(jitter.rms_spin, jitter.rest_drift),
    scale=HALF,
)
