"""Balls in a container, packed so that they touch: what does a heap of n bodies cost, and does it lie still?

The packing is that of cannon balls: square layers, each ball in the hollow of four below, so that every engine has the same
contacts from the first step on and the walls carry their share. Piles that fall into place differ from engine to engine.
"""

import math

import numpy as np

from plumbline.harness.case import Axis, Case, Check, FloatCount, NotNegative, Parameters
from plumbline.harness.case.bounds import settled_speed
from plumbline.harness.metrics import equivalence, jitter, overlaps
from plumbline.harness.props.robots.container import container
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.trajectory import Floats
from plumbline.harness.truths.friction import resting

RADIUS, DENSITY = 0.05, 1000.0
SETTLED, DURATION = 0.5, 1.0


class P(Parameters):
    n: FloatCount = 20
    """A hundred balls take some engines a second a step; the numbers beyond belong to the axis and to the study of scaling."""
    friction: NotNegative = 0.5
    worlds: FloatCount = 1


def side(n: int) -> int:
    """Balls along an edge of the lowest layer: a heap of n = sqrt(2) side^3 balls is as high as it is wide."""
    return max(1, math.ceil(math.pow(n / math.sqrt(2), 1 / 3)))


def packing(n: int) -> Floats:
    """Centres (n, 3) m in units of RADIUS, layer upon layer of side^2 and (side - 1)^2 balls, about the middle of the floor."""
    edge, centres = side(n), list[tuple[float, float, float]]()
    layer = 0
    while len(centres) < n:
        inner = layer % 2 if edge > 1 else 0
        height = 1.0 + layer * (math.sqrt(2) if edge > 1 else 2.0)
        places = np.arange(edge - inner) * 2.0 - (edge - inner - 1)
        centres += [(float(x), float(y), height) for y in places for x in places]
        layer += 1
    return np.array(centres[:n])


def scene(p: P) -> Scene:
    """A floor, four walls and n equal balls, all just touching; `worlds` of them are stepped together."""
    count = round(p.n)
    mass = DENSITY * 4 / 3 * math.pi * RADIUS**3
    balls = [
        Body.ball(f"ball_{k}", RADIUS, mass=mass, material="ball", p_WB=(RADIUS * centre).tolist())
        for k, centre in enumerate(packing(count))
    ]
    laws = tuple(Surface.rough(p.friction, pair) for pair in (("ball", "ball"), ("ball", "wall")))
    return Scene(bodies=(*container(RADIUS * side(count), "wall"), *balls), surfaces=laws)


expected = resting(scene)

CASE = Case.of(
    globals(),
    title="Balls in a container",
    question="Do n balls packed in a container stay in it and apart from each other, come to rest, and at what price?",
    source="statics of the face-centred cubic packing: each ball in the hollow of four others, held together by the walls",
    truth="rest",
    sample_interval=1 / 20,
    ladder=(1 / 60, 1 / 120, 1 / 240, 1 / 360, 1 / 480, 1 / 960),
    steady=SETTLED,
    worlds="worlds",
    hard=Axis(parameter="n", unit="1", easy=10, extreme=10_000),
    checks=(
        Check(
            overlaps.overlap,
            RADIUS,
            "the definition of broken: half the thinnest body; a ball outside is deeper than that in a wall",
        ),
        settled_speed(SETTLED, "a ball"),
        Check(equivalence.world_spread, 0.0, "equal input gives an equal future, bit for bit"),
    ),
    observe=(jitter.rest_drift,),
    insists={"friction": "balls that roll over each other without friction are another material, and cost an engine less"},
    scale=RADIUS,
)
