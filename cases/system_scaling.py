"""n bodies that fly, n boxes that jostle on a floor, or a chain of n rods, all pushed about at random: what does a step cost?

Idle scenes flatter an engine: its sweeps end at once, its contacts stay the same, its bodies may sleep. Here every body is
pushed and turned by random forces that change sixty times a second, the same for every engine at every step.
"""

import math

import numpy as np

from plumbline.harness.case import Axis, Case, Check, FloatCount, Parameters
from plumbline.harness.case.forces import Control
from plumbline.harness.metrics import errors, joints, overlaps
from plumbline.harness.scene import WORLD, Body, Box, PlacedShape, Revolute, Scene, Surface
from plumbline.harness.trajectory import Floats, State, Trajectory

KINDS = ("flight", "contact", "chain")
MASS, HALF, GAP, FRICTION = 1.0, 0.1, 1e-3, 0.5
ROD = (0.02, 0.02, 0.1)
INTERVAL, DURATION, STEADY = 1 / 60, 1.0, 0.25
PUSH, TWIST = 5.0, 0.2
"""Standard deviations of each component of the forces [N], half a body's weight, and of the torques [N m]."""


class P(Parameters):
    kind: str = "contact"
    n: FloatCount = 10
    seed: int = 0


def scene(p: P) -> Scene:
    """'flight': n cubes without weight that never touch; 'contact': n cubes side by side on a floor, a millimetre apart;
    'chain': n rods on hinges whose axes lie along x and y by turns, hanging from the world."""
    count = round(p.n)
    if p.kind == "chain":
        return _chain(count)
    if p.kind not in KINDS:
        raise ValueError(f"kind '{p.kind}', expected one of {', '.join(KINDS)}")
    edge, lattice = math.ceil(math.sqrt(count)), 2 * HALF + GAP
    touching = p.kind == "contact"
    cubes = [
        Body.box(
            f"cube_{k}",
            (HALF, HALF, HALF),
            mass=MASS,
            touches=touching,
            visual=(PlacedShape(shape=Box(half_extents=(HALF, HALF, HALF))),),
            p_WB=(lattice * (k % edge - (edge - 1) / 2), lattice * (k // edge - (edge - 1) / 2), HALF),
        )
        for k in range(count)
    ]
    if not touching:
        return Scene(bodies=tuple(cubes), gravity=(0.0, 0.0, 0.0))
    half = (edge * lattice + 5.0, edge * lattice + 5.0, 0.5)
    floor = Body.fixed("floor", Box(half_extents=half), p_WB=(0.0, 0.0, -0.5))
    law = Surface.rough(FRICTION)
    return Scene(bodies=(floor, *cubes), surfaces=(law,))


def _chain(count: int) -> Scene:
    length = 2 * ROD[2]
    rods = tuple(
        Body.box(f"rod_{k}", ROD, mass=MASS, touches=False, p_WB=(0.0, 0.0, -length * (k + 0.5))) for k in range(count)
    )
    hinges = tuple(
        Revolute(
            name=f"hinge_{k}",
            parent=f"rod_{k - 1}" if k else WORLD,
            child=f"rod_{k}",
            anchor_W=(0.0, 0.0, -length * k),
            axis_W=(1.0, 0.0, 0.0) if k % 2 else (0.0, 1.0, 0.0),
        )
        for k in range(count)
    )
    return Scene(bodies=rods, joints=hinges)


def noise(interval: int, bodies: int, seed: int) -> tuple[Floats, Floats]:
    """Forces and torques (bodies, 3) of one interval; a body's do not depend on how many others there are."""
    drawn = np.random.default_rng((seed, interval)).standard_normal((bodies, 2, 3))
    return PUSH * drawn[:, 0], TWIST * drawn[:, 1]


def control(p: P) -> Control:
    """The random forces, held for a sixtieth of a second each; what cannot move takes no notice."""
    fixed = 1 if p.kind == "contact" else 0

    def wrench(time: float, _state: State) -> tuple[Floats, Floats]:
        force, torque = noise(round(time / INTERVAL), round(p.n), p.seed)
        still = np.zeros((fixed, 3))
        return np.concatenate([still, force]), np.concatenate([still, torque])

    return Control(wrench=wrench, interval=INTERVAL)


def expected(time: Floats, p: P) -> Trajectory | None:
    """Of cubes in flight: parabola after parabola. A cube has no gyroscopic torque, and its turning is not told here."""
    if p.kind != "flight":
        return None
    truth, count = Trajectory.of(time, round(p.n)), round(p.n)
    last = int(np.floor(truth.time.max(initial=0.0) / INTERVAL + 1e-9)) + 1
    pushes = np.stack([noise(k, count, p.seed)[0] for k in range(last)]) / MASS
    v = np.concatenate([np.zeros((1, count, 3)), np.cumsum(pushes, axis=0) * INTERVAL])
    moved = np.concatenate([np.zeros((1, count, 3)), np.cumsum(v[:-1] * INTERVAL + pushes * INTERVAL**2 / 2, axis=0)])
    here = np.floor(truth.time / INTERVAL + 1e-9).astype(np.int64)
    since = (truth.time - here * INTERVAL)[:, None, None]
    start = np.array([body.p_WB for body in scene(p).bodies])
    truth.v_WB[:] = v[here] + pushes[here] * since
    truth.p_WB[:] = start + moved[here] + v[here] * since + pushes[here] * since**2 / 2
    return truth


CASE = Case.of(
    globals(),
    title="A crowd pushed about",
    question="What does a step of n bodies cost while they are pushed about, and do they hold together?",
    source="Newton, Principia, law II, for the flight; the price is measured",
    truth="closed form",
    steady=STEADY,
    hard=Axis(parameter="n", unit="1", easy=1, extreme=1000),
    headline=overlaps.inscribed_overlap.name,
    scale=HALF,
    checks=(
        Check(
            errors.position_error_max,
            lambda dt, _: 6 * PUSH / MASS * math.sqrt(DURATION * INTERVAL) * math.sqrt(3) * dt,
            "a first-order method errs by dt/2 times the change of velocity, a sum of random pushes whose components "
            "spread by sigma sqrt(t T)/m; six of these are never exceeded, and a factor of 2 is left to spare",
        ),
        Check(overlaps.inscribed_overlap, HALF, "the definition of broken: half the thinnest body"),
        Check(joints.joint_gap_max, ROD[0], "the definition of broken: half the thinnest body"),
    ),
)
