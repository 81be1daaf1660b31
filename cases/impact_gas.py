"""A gas of elastic spheres in a box that is itself free: momentum, angular momentum and energy of the whole stay.

The box moves as the spheres do, so that nothing outside acts and all three are kept, however chaotic the motion. The walls make
a cube, whose inertia is the same about every axis, and nothing rubs: no sphere is ever turned, and no gyroscopic torque acts.
"""

import math

import numpy as np

from plumbline.harness.case import Axis, Case, Check, FloatCount, Parameters
from plumbline.harness.metrics import conservation, overlaps
from plumbline.harness.metrics.conservation import energy_drift_final, energy_growth_rate
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Surface, principal_inertia
from plumbline.harness.trajectory import Floats

SPEED = 1.0
MASS, RADIUS, CELL, WALL, BOX_MASS = 1.0, 0.05, 0.25, 0.1, 500.0
DURATION = 1.0


class P(Parameters):
    edge: FloatCount = 6
    speed: float = SPEED
    seed: int = 0


def _walls(inner: float) -> tuple[PlacedShape, ...]:
    """Six slabs about a cube of the half edge `inner` [m]; they overlap at the edges, so that no corner is open."""
    walls = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            half, centre = [inner + 2 * WALL] * 3, [0.0] * 3
            half[axis], centre[axis] = WALL, side * (inner + WALL)
            walls.append(
                PlacedShape(shape=Box(half_extents=(half[0], half[1], half[2])), p_BS=(centre[0], centre[1], centre[2]))
            )
    return tuple(walls)


def _velocities(count: int, speed: float, seed: int) -> Floats:
    """Directions drawn evenly over the sphere, (count, 3) m/s, less their mean: the gas as a whole rests."""
    drawn = np.random.default_rng(seed).standard_normal((count, 3))
    drawn -= drawn.mean(axis=0)
    scaled: Floats = drawn * speed / np.sqrt(np.mean(np.sum(drawn**2, axis=1)))
    return scaled


def scene(p: P) -> Scene:
    """edge^3 spheres on a lattice in a free hollow cube at random velocities of root mean square `speed` [m/s]; no gravity."""
    n = round(p.edge)
    inner = n * CELL / 2
    places = [(CELL * (i + 0.5) - inner, CELL * (j + 0.5) - inner, CELL * (k + 0.5) - inner)
              for i in range(n) for j in range(n) for k in range(n)]  # fmt: skip
    moment = BOX_MASS * 2 / 3 * (inner + WALL) ** 2
    box = Body(
        name="box",
        mass=BOX_MASS,
        inertia=principal_inertia(moment, moment, moment),
        material="box",
        collision=_walls(inner),
    )
    spheres = [
        Body.ball(f"sphere_{i}", RADIUS, mass=MASS, material="sphere", p_WB=centre, v_WB=velocity.tolist())
        for i, (centre, velocity) in enumerate(zip(places, _velocities(len(places), p.speed, p.seed), strict=True))
    ]
    return Scene(
        bodies=(box, *spheres),
        surfaces=(Surface(between=("sphere", "sphere"), restitution=1.0), Surface(between=("sphere", "box"), restitution=1.0)),
        gravity=(0.0, 0.0, 0.0),
    )


def growth(dt: float, p: P) -> float:
    """How fast [1/s] energy grows where each approach is measured a whole step dt [s] before it is answered.

    The line of centres of two spheres that close at v turns with v_t/d, so that a step earlier they seem to close faster by
    v_t^2 dt/d: the impact gains mu u v_t^2 dt/d. Averaged over the area of aim that is 8/15 (v dt/d) mu v^2/2, and over
    Maxwell's relative speeds, of variance 2 V^2/3 along each axis, with n pi d^2 v impacts a second:
    dE/dt = n pi d^2/2 * 8/15 (dt/d) (m/4) <v^4> for each sphere, with <v^4> = 15 (2 V^2/3)^2.

    Source: Chapman, Cowling, The Mathematical Theory of Non-uniform Gases, 3rd ed., chapter 5 (frequency of collisions).
    """
    d, density = 2 * RADIUS, 1 / CELL**3
    spread = math.sqrt(2 / 3) * p.speed
    fourth, energy = 15 * spread**4, MASS * p.speed**2 / 2
    won = 8 / 15 * dt / d * (MASS / 2) / 2
    return density * math.pi * d**2 / 2 * won * fourth / energy


CASE = Case.of(
    globals(),
    title="Elastic gas in a free box",
    question="Do momentum, angular momentum and energy of an elastic gas stay, impact after impact?",
    source="conservation of momentum, angular momentum and energy; kinetic theory",
    truth="conservation",
    hard=Axis(parameter="speed", unit="m/s", easy=0.5, extreme=100.0, lost=0.1),
    sample_interval=1 / 60,
    ladder=(1 / 120, 1 / 240, 1 / 480, 1 / 960, 1 / 1920, 1 / 3840),
    checks=(
        Check(overlaps.escaped_share, 0.0, "walls keep the gas in; what ignores them would keep all three sums too"),
        Check(
            conservation.momentum_drift_max,
            lambda _, p: 1e-6 * p.edge**3 * MASS * p.speed,
            "an impact gives to one what it takes from the other; 1e-6 of all momentum there is, single precision",
        ),
        Check(
            conservation.angular_momentum_drift_max,
            1e-6,
            "an impact acts along one line on both, with equal arms; 1e-6 for single precision. What moves spheres "
            "apart without an impulse shifts momentum aside",
        ),
        Check(
            energy_growth_rate,
            growth,
            "an elastic impact keeps energy; a scheme that measures the approach one step before it answers it gains "
            "8/15 v dt/d of the energy of closing on average, n pi d^2 v times a second",
        ),
    ),
    observe=(energy_drift_final,),
    headline=energy_growth_rate.name,
)
