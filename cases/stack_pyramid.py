"""Two pyramids of n rows: bricks upright on the ground, and balls upside down in a cone.

The bricks stand row on row, each across the joint of the two below; the balls are layers of 1, 4, 9, ... in a hollow of four
planes, each ball in the hollow of four below or against the walls. Both just touch, and both rest. Ten rows are what the axis
is for: an engine whose solver takes the cube of the number of contacts needs a second for a step of them.
"""

import math
from collections.abc import Iterator

from plumbline.harness.case import Axis, Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import GIVE, G, settled_speed, stands, supported
from plumbline.harness.metrics import contacts, jitter, stack
from plumbline.harness.scene import Body, Effect, Plane, Scene, Surface
from plumbline.harness.truths.friction import resting

MASS = 1.0
SETTLED, DURATION = 0.5, 1.0
HALF = (0.1, 0.1, 0.05)
PITCH = 2.2 * HALF[0]
"""Distance of the bricks of a row [m]: a tenth of a brick is free between them, so that no force goes along a row."""
RADIUS = 0.1
WALLS = {"west": (1, 0), "east": (-1, 0), "south": (0, 1), "north": (0, -1)}
SLOPE = math.atan(math.sqrt(2.0))
"""Of the walls against the ground [rad]: that of the densest planes through such a packing, which touch all balls at the edge
of their layers."""
PLACE = 10.0
"""The tip of the hollow stands at this x [m], beyond the ground on which the bricks stand."""


class P(Parameters):
    rows: FloatCount = 3
    friction: NotNegative = 0.5


def bricks(rows: int) -> Iterator[Body]:
    """n bricks on the ground, n - 1 above them, and so on, in the plane y = 0."""
    for row in range(rows):
        for i in range(rows - row):
            yield Body.box(
                f"brick_{row}_{i}",
                HALF,
                mass=MASS,
                material="brick",
                p_WB=(PITCH * (i - (rows - row - 1) / 2), 0.0, HALF[2] * (2 * row + 1)),
            )


def balls(rows: int) -> Iterator[Body]:
    """1, 4, ..., n^2 balls in square layers, the lowest in the tip of the hollow, which stands at the origin of its planes."""
    lowest = RADIUS / math.cos(SLOPE)
    for row in range(rows):
        for i in range(row + 1):
            for j in range(row + 1):
                yield Body.ball(
                    f"ball_{row}_{i}_{j}",
                    RADIUS,
                    mass=MASS,
                    material="ball",
                    p_WB=(RADIUS * (2 * i - row) + PLACE, RADIUS * (2 * j - row), lowest + math.sqrt(2.0) * RADIUS * row),
                )


def scene(p: P) -> Scene:
    """Both pyramids, beside each other, exactly touching."""
    walls = [
        Body.fixed(
            name,
            Plane(normal=(x * math.sin(SLOPE), y * math.sin(SLOPE), math.cos(SLOPE))),
            material="wall",
            p_WB=(PLACE, 0.0, 0.0),
        )
        for name, (x, y) in WALLS.items()
    ]
    touching = (("brick", "ground"), ("brick", "brick"), ("ball", "wall"), ("ball", "ball"))
    # Planes have no end: without this the bricks would stand inside of a wall of the hollow.
    apart = (("brick", "wall"), ("brick", "ball"), ("ball", "ground"))
    return Scene(
        bodies=(Body.ground(), *walls, *bricks(round(p.rows)), *balls(round(p.rows))),
        surfaces=tuple(Surface.rough(p.friction, pair) for pair in touching),
        apart=apart,
        narrow=Effect.GYROSCOPIC,
    )


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="Pyramids of bricks and of balls",
    question="Do a pyramid of bricks and one of balls, upside down in a hollow, stay as they are built?",
    source="statics: each brick on the two below, each ball in the hollow of four others or of the walls, in equilibrium",
    truth="rest",
    steady=SETTLED,
    hard=Axis(parameter="rows", unit="1", easy=1, extreme=10),
    checks=(
        stands(DURATION, "the pyramids stand"),
        Check(
            jitter.rest_drift,
            lambda dt, p: math.sqrt(3.0) * p.rows * (G * dt**2 + GIVE),
            "before a contact can push, a body falls for one step, g dt^2, and a millimetre is what it may give way "
            "under weight; if the contacts of each row gave as much, the top would sink by that for each row, and sqrt(3) "
            "times as deep between walls of 54.7 degrees",
        ),
        settled_speed(SETTLED),
        supported(SETTLED, DURATION),
    ),
    observe=(contacts.penetration, stack.lean, stack.residual_kinetic_energy),
    headline="rest_drift",
    scale=RADIUS,
)
