"""Boxes pressed against a wall: which hold, and which slide down it, and how fast?

A push F holds a box of weight m g iff mu F >= m g; what does not hold falls with g - mu F/m. The push is a field: gravity leans
towards the wall.
"""

from plumbline.harness.case import Axis, Case, Check, Parameters
from plumbline.harness.case.bounds import G, forces_obey_coulomb
from plumbline.harness.metrics import errors, slide
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

DURATION = 1.0
PUSH, MASS, SPACING = 2.0, 1.0, 0.5
FRICTIONS = (0.3, 0.45, 0.48, 0.52, 0.55, 0.8)
"""Coefficients around the threshold 1/PUSH, on either side of it."""
HALF = (0.1, 0.1, 0.1)
THICKNESS = 0.1
LONG = 6.0
"""Half extents [m] of the wall along its normal and down."""


class P(Parameters):
    push: float = PUSH
    frictions: tuple[float, ...] = FRICTIONS


def scene(p: P) -> Scene:
    """One box for each coefficient, side by side along y, against a wall in the plane x = 0, pushed by `push` times its "
    "weight."""
    boxes = [
        Body.box(f"box_{i}", HALF, mass=MASS, material=f"box_{i}", p_WB=(-HALF[0], SPACING * i, 0.0))
        for i in range(len(p.frictions))
    ]
    width = SPACING * len(p.frictions)
    wall = Body.fixed("wall", Box(half_extents=(THICKNESS, width, LONG)), material="wall", p_WB=(THICKNESS, 0.0, 0.0))
    names = [box.material for box in boxes]
    return Scene(
        bodies=(wall, *boxes),
        gravity=(p.push * G, 0.0, -G),
        surfaces=tuple(Surface.rough(mu, (name, "wall")) for name, mu in zip(names, p.frictions, strict=True)),
        apart=tuple((a, b) for i, a in enumerate(names) for b in names[i + 1 :]),
        # Boxes flat against a wall never turn.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """Rest or uniform acceleration down the wall."""
    truth = Trajectory.at_rest(scene(p), time)
    for i, mu in enumerate(p.frictions, start=1):
        a = max(0.0, G * (1 - mu * p.push))
        truth.p_WB[:, i, 2] = -a * truth.time**2 / 2
        truth.v_WB[:, i, 2] = -a * truth.time
    return truth


def _speed(dt: float, _: P) -> float:
    """The first step may pass before there is a contact: then a box falls freely for it, twice for a soft contact."""
    return 2 * G * dt


CASE = Case.of(
    globals(),
    title="Pinched against a wall",
    question="Does a push against a wall hold a box exactly where friction times push reaches its weight?",
    source="Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3",
    truth="closed form",
    hard=Axis(parameter="push", unit="1", easy=2.0, extreme=2e4, lost=0.1),
    headline=errors.position_error_max.name,
    converges="once",
    checks=(
        Check(errors.velocity_error_max, _speed, "a first step without a contact is a step of free fall, taken twice"),
        Check(
            errors.position_error_max,
            lambda dt, p: _speed(dt, p) * DURATION + 1e-3,
            "the error of the speed all the way, and a millimetre for contacts that give way under the push",
        ),
        Check(
            slide.creep_speed,
            1e-4,
            "a tenth of a millimetre a second: a gripper that holds an object for ten seconds loses a millimetre. "
            "Coulomb's law allows none",
            start=0.5,
        ),
        *forces_obey_coulomb(),
    ),
    observe=(errors.position_error_final,),
)
