"""A block drawn along by a spring whose far end moves on steadily: it sticks, breaks away, slips and sticks again.

It sticks until the spring pulls with mu_s m g, then swings about the force mu_k m g. Each slip shortens the spring by
2 (mu_s - mu_k) m g/k less what the far end goes meanwhile, so that the motion repeats itself with the period
T = 2 (mu_s - mu_k) g/(w^2 v) + (2/w) (pi - atan((mu_s - mu_k) g/(w v))), w^2 = k/m, but for the first stick.
"""

import math

import numpy as np

from plumbline.harness.case import Case, Check, NotNegative, Parameters, Positive
from plumbline.harness.case.bounds import GIVE, G, forces_obey_coulomb
from plumbline.harness.metrics.errors import position_error_final, position_error_max, velocity_error_max
from plumbline.harness.scene import Body, Distance, Effect, Scene, Spring, Surface
from plumbline.harness.trajectory import Floats, Trajectory

DURATION = 4.0
MASS = 1.0
REST = 1.0
"""Length of the slack spring [m]."""
HALF = (0.2, 0.2, 0.05)


class P(Parameters):
    static: NotNegative = 0.6
    kinetic: NotNegative = 0.4
    stiffness: Positive = 20.0
    drawn: Positive = 0.2


def scene(p: P) -> Scene:
    """A block on the ground and a puller `REST` m ahead of its centre that moves on at `drawn` [m/s], with a slack spring."""
    block = Body.box("block", HALF, mass=MASS, material="block", p_WB=(0.0, 0.0, HALF[2]))
    puller = Body(name="puller", motion="kinematic", p_WB=(REST, 0.0, HALF[2]), v_WB=(p.drawn, 0.0, 0.0))
    line = Distance(
        name="spring",
        parent="puller",
        child="block",
        anchor_W=(REST, 0.0, HALF[2]),
        child_anchor_W=(0.0, 0.0, HALF[2]),
        spring=Spring(stiffness=p.stiffness, rest=REST),
    )
    return Scene(
        bodies=(Body.ground(), block, puller),
        joints=(line,),
        surfaces=(Surface(between=("block", "ground"), static_friction=p.static, kinetic_friction=p.kinetic),),
        # The block slides flat and never turns.
        narrow=Effect.GYROSCOPIC,
    )


def _block(time: Floats, static: float, kinetic: float, stiffness: float, drawn: float) -> tuple[Floats, Floats]:
    """Way [m] and speed [m/s] of the block at ascending times, each (t,)."""
    w = math.sqrt(stiffness / MASS)
    x, v = np.zeros(len(time)), np.zeros(len(time))
    here, stuck, at = 0.0, True, 0.0
    while here <= (time[-1] if len(time) else -1.0):
        # The spring pulls with k (v t - x).
        if stuck:
            away = (static * MASS * G / stiffness + at) / drawn
            inside = (time >= here) & (time <= away)
            x[inside] = at
            here, stuck = away, False
        else:
            # y = v t - x - mu_k m g/k swings from (mu_s - mu_k) m g/k at the rate v until y' is v again: x' = 0.
            y = (static - kinetic) * MASS * G / stiffness
            lasts = 2 / w * (math.pi - math.atan(y * w / drawn))
            inside = (time >= here) & (time <= here + lasts)
            t = time[inside] - here
            swing = y * np.cos(w * t) + drawn / w * np.sin(w * t)
            rate = -y * w * np.sin(w * t) + drawn * np.cos(w * t)
            x[inside] = drawn * time[inside] - kinetic * MASS * G / stiffness - swing
            v[inside] = drawn - rate
            here += lasts
            end = y * math.cos(w * lasts) + drawn / w * math.sin(w * lasts)
            at, stuck = drawn * here - kinetic * MASS * G / stiffness - end, True
    return x, v


def expected(time: Floats, p: P) -> Trajectory:
    """Sticking and slipping in turns."""
    truth = Trajectory.at_rest(scene(p), time)
    truth.p_WB[:, 1, 0], truth.v_WB[:, 1, 0] = _block(truth.time, p.static, p.kinetic, p.stiffness, p.drawn)
    truth.p_WB[:, 2, 0] += p.drawn * truth.time
    truth.v_WB[:, 2, 0] = p.drawn
    return truth


def _slips(static: float, kinetic: float, stiffness: float, drawn: float) -> int:
    """How many slips begin within the duration: at the first break-away, and a period after each other."""
    w, y = math.sqrt(stiffness / MASS), (static - kinetic) * G
    first = static * MASS * G / (stiffness * drawn)
    period = 2 * y / (w**2 * drawn) + 2 / w * (math.pi - math.atan(y / (w * drawn)))
    return 0 if first > DURATION else 1 + int((DURATION - first) / period)


def _way(dt: float, p: P) -> float:
    """The way [m] in a slip, at its fastest, over the time by which slips are late: break-away and sticking are noticed up to a
    step late each, and a first-order swing errs by half a step besides."""
    fastest = p.drawn + math.hypot((p.static - p.kinetic) * G / math.sqrt(p.stiffness / MASS), p.drawn)
    return fastest * 3 * _slips(p.static, p.kinetic, p.stiffness, p.drawn) * dt


CASE = Case.of(
    globals(),
    title="Stick and slip",
    question="Does a drawn block break away at the static coefficient and slip under the kinetic one?",
    source="Rabinowicz, Friction and Wear of Materials, 2nd ed., section 4.10: stick-slip of a spring-drawn slider",
    truth="closed form",
    converges="once",
    checks=(
        Check(
            position_error_max,
            lambda dt, p: _way(dt, p) + GIVE,
            "break-away and sticking are noticed up to a step late each, and a first-order swing errs by half a step: "
            "three steps of way a slip, and a millimetre for contacts that give way before they hold",
        ),
        Check(
            velocity_error_max,
            lambda dt, p: _way(dt, p) * math.sqrt(p.stiffness / MASS) + p.static * G * dt,
            "the swing's acceleration over the time by which it is late, and one step of friction at its end",
        ),
        *forces_obey_coulomb(),
    ),
    observe=(position_error_final,),
)
