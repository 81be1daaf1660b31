"""Balls of very different mass that meet head-on.

Momentum is kept and the speed of parting is e times that of closing: v1 = (m1 u1 + m2 u2 + m2 e (u2 - u1))/(m1 + m2), and the
same with 1 and 2 exchanged. Newton, Principia, scholium to the laws of motion.
"""

from collections.abc import Sequence
from itertools import product

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import SOLVED, SPRING_STEPS, forces_keep_momentum
from plumbline.harness.metrics import conservation, errors
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

MASS, RADIUS, SPACING = 1.0, 0.1, 1.0
GAP, WIDER = 0.3, 0.011
"""Of the first pair, and how much wider it is in each next one, so that every pair meets at another phase of the step [m]; the
first one meets at the very end of a step."""
CLOSING = (2.0, -1.0)
"""Velocities of the left and the right ball before they meet [m/s]; neither is at rest, so that no frame is special."""
SPEED = CLOSING[0] - CLOSING[1]
DURATION = 0.5


class P(Parameters):
    ratio: Positive = 1000.0
    restitutions: tuple[float, ...] = (0.0, 0.5, 0.8, 1.0)


def _pairs(ratio: float, restitutions: Sequence[float]) -> list[tuple[int, float, float]]:
    """Place of the restitution and masses [kg] of each pair: heavy on light, equal, light on heavy."""
    masses = ((MASS * ratio, MASS), (MASS, MASS), (MASS, MASS * ratio))
    return [(i, left, right) for i, (left, right) in product(range(len(restitutions)), masses)]


def parted(left: float, right: float, restitution: float) -> tuple[float, float]:
    """The velocities [m/s] of two masses [kg] after they have met at the velocities CLOSING."""
    u1, u2 = CLOSING
    common = (left * u1 + right * u2) / (left + right)
    back = restitution * (u2 - u1) / (left + right)
    return common + right * back, common - left * back


def scene(p: P) -> Scene:
    """Pairs side by side along y: for each restitution one of masses ratio:1, one of 1:1 and one of 1:ratio; no gravity."""
    balls = []
    for row, (kind, *masses) in enumerate(_pairs(p.ratio, p.restitutions)):
        for side, mass, direction, speed in zip(("left", "right"), masses, (-1, 1), CLOSING, strict=True):
            balls.append(
                Body.ball(
                    f"{side}_{row}",
                    RADIUS,
                    mass=mass,
                    material=f"e_{kind}",
                    p_WB=(direction * (RADIUS + (GAP + WIDER * row) / 2), SPACING * row, 0.0),
                    v_WB=(speed, 0.0, 0.0),
                )
            )
    kinds = [f"e_{i}" for i in range(len(p.restitutions))]
    return Scene(
        bodies=tuple(balls),
        surfaces=tuple(Surface(between=(kind, kind), restitution=e) for kind, e in zip(kinds, p.restitutions, strict=True)),
        gravity=(0.0, 0.0, 0.0),
        apart=tuple((a, b) for i, a in enumerate(kinds) for b in kinds[i + 1 :]),
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: straight flight, one impulse, straight flight."""
    truth = Trajectory.at_rest(scene(p), time)
    for row, (kind, left, right) in enumerate(_pairs(p.ratio, p.restitutions)):
        meeting = (GAP + WIDER * row) / SPEED
        before, since = np.minimum(truth.time, meeting), np.maximum(truth.time - meeting, 0.0)
        for place, u, v in zip((2 * row, 2 * row + 1), CLOSING, parted(left, right, p.restitutions[kind]), strict=True):
            truth.p_WB[:, place, 0] += u * before + v * since
            truth.v_WB[:, place, 0] = np.where(truth.time < meeting, u, v)
    return truth


EXACT = 1e-6 * SPEED
IMPULSE = SOLVED * 2 * SPEED + EXACT
NO_STEP = (
    "where no force acts between impacts, an impulse is the same at every time step, so that the law leaves no error of it: "
    "the share of an impulse to which forces are solved for, 1e-4, of the largest change of velocity, twice the speed of "
    "closing; and 1e-6 of that speed, single precision with its sums"
)


CASE = Case.of(
    globals(),
    title="Head-on pairs",
    question="Do two balls of very different mass part as momentum and restitution say?",
    source="Newton, Principia, scholium to the laws of motion; Stronge, Impact Mechanics, 2nd ed., section 2.3",
    truth="closed form",
    hard=Axis(parameter="ratio", unit="1", easy=1.0, extreme=1e6, lost=0.1),
    sample_interval=0.0,
    checks=(
        Check(errors.velocity_error_final, IMPULSE, NO_STEP),
        Check(
            errors.position_error_final,
            lambda dt, _: max(2, SPRING_STEPS / 2) * 2 * SPEED * dt + IMPULSE * DURATION,
            "the impact may come one step early or late and take one step, in which the lighter ball goes the change "
            "of its velocity astray, at most twice the speed of closing; or take a spring's ten steps, half of which it goes "
            "so astray; and the bound on its velocity for the rest of the run",
        ),
        Check(
            conservation.momentum_drift_max,
            lambda _dt, p: 1e-6 * 4 * len(p.restitutions) * (p.ratio + 1) * MASS * SPEED,
            "an impact gives to one what it takes from the other; 1e-6 of all momentum there is, single precision",
        ),
        Check(errors.angular_velocity_error_final, EXACT / RADIUS, "a blow along the line of centres turns nothing"),
        forces_keep_momentum(),
    ),
    scale=SPEED,
)
