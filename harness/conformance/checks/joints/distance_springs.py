"""Checks of springs and dampers between points of two bodies: their law along the line, and where they pull."""

from math import exp

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, near
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.conformance.frames import ORIGIN, TURNED, UPRIGHT, Z, aligned, rotation, vector
from plumbline.harness.conformance.scenes import free, tie, without_gravity
from plumbline.harness.scene import Scene, Spring, rotate
from plumbline.harness.trajectory import Floats

_FIRST = "a staggered scheme of first order is off by half a step of motion"


@check(
    "Does a spring between two bodies swing at sqrt(k/m) of their reduced mass, and its damper damp?", Feature.DISTANCE_SPRING
)
def distance_spring_has_its_frequency(engine: Engine) -> Comparisons:
    """Two bodies of 2 and 1 kg on a slanted line: m l'' = -k (l - rest) - c l' with m = 2/3 kg; their centre stays."""
    a, b = np.array([0.3, -0.2, 0.1]), np.array([0.3, -0.2, 0.1]) + 0.8 * np.array([2.0, -1.0, 2.0]) / 3
    stiffness, rest, mass = 40.0, 0.6, 2.0 / 3.0
    for c in (0.0, 2.0):
        spring = Spring(stiffness=stiffness, damping=c, rest=rest)
        line = tie("line", "light", vector(a), vector(b), spring=spring, parent="heavy")
        bodies = (free("heavy", mass=2.0, p=vector(a)), free("light", mass=1.0, p=vector(b), q=TURNED))
        run = engine.record(without_gravity(*bodies, joints=(line,)), 0.6, every=20)
        decay = c / (2.0 * mass)
        omega = np.sqrt(stiffness / mass - decay**2)
        t = run.time
        length = rest + 0.2 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
        got = np.linalg.norm(run.p_WB[:, 1] - run.p_WB[:, 0], axis=1)
        centre = (2.0 * run.p_WB[:, 0] + run.p_WB[:, 1]) / 3.0
        off, because = np.abs(got - length).max(), "1.6 m/s times dt/2, and twice that for a damper taken implicitly"
        yield near(f"worst distance to the closed form at damping {c} N s/m [m]", off, 0.0, 4e-3, f"{because}: {_FIRST}")
        off, because = np.abs(centre - (2.0 * a + b) / 3.0).max(), "the two forces are opposite; rounding"
        yield near(f"worst way of the common centre at damping {c} N s/m [m]", off, 0.0, 1e-6, because)


@check("Does a spring pull at its anchors, off the centre of mass, and turn what it pulls?", Feature.DISTANCE_SPRING)
def distance_spring_pulls_where_it_is_tied(engine: Engine) -> Comparisons:
    """A turned ball-like body hung by an arm from the world on a spring, against the equations of motion integrated to 1e-10.

    m v' = m g + f u, I w' = r x f u, r' = w x r; I is a multiple of the identity, so that the attitude is told by r alone.
    """
    mass, moment, t = 2.0, 0.3, 0.4
    arm, anchor, start = (0.3, 0.1, -0.2), np.array([0.2, -0.4, 1.0]), np.array([0.5, 0.2, 0.1])
    spring = Spring(stiffness=60.0, damping=3.0, rest=0.5)
    r0 = np.array(rotate(TURNED, arm))
    body = free("body", mass=mass, moments=(moment,) * 3, p=vector(start), q=TURNED)
    line = tie("line", "body", vector(anchor), vector(start + r0), spring=spring)
    scene = Scene(bodies=(body,), joints=(line,))

    def rate(_: float, y: Floats) -> Floats:
        p, v, w, r = y.reshape(4, 3)
        way = p + r - anchor
        length = float(np.linalg.norm(way))
        u = way / length
        speed = float(u @ (v + np.cross(w, r)))
        f = (spring.stiffness * (spring.rest - length) - spring.damping * speed) * u
        return np.concatenate((v, f / mass + np.array(scene.gravity), np.cross(r, f) / moment, np.cross(w, r)))

    y0 = np.concatenate((start, ORIGIN, ORIGIN, r0))
    p, v, w, r = solve_ivp(rate, (0.0, t), y0, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1].reshape(4, 3)
    end = engine.final(scene, t)
    yield near("place [m]", end.p_WB[0], p, 4e-3, f"2 m/s times dt: {_FIRST}")
    yield near("velocity [m/s]", end.v_WB[0], v, 0.05, f"20 m/s2 times dt, and default damping: {_FIRST}")
    yield near("angular velocity [rad/s]", end.w_WB[0], w, 0.1, f"50 rad/s2 times dt, and default damping: {_FIRST}")
    yield near("the arm in W [m]", rotation(end.q_WB[0]) @ arm, r, 5e-3, f"|w| |r| dt, and default damping: {_FIRST}")


@check("Does what hangs on a spring and damper come to rest where the spring bears its weight?", Feature.DISTANCE_SPRING)
def distance_spring_holds_what_hangs(engine: Engine) -> Comparisons:
    """A body let go on a spring and damper, critically damped at 20/s: after a second it hangs at rest, lower by m g/k."""
    mass, stiffness, damping = 2.0, 800.0, 80.0
    line = tie("line", "body", Z, ORIGIN, spring=Spring(stiffness=stiffness, damping=damping, rest=1.0))
    end = engine.final(Scene(bodies=(free("body", mass=mass),), joints=(line,)), 1.0)
    sag = mass * 9.81 / stiffness
    because = f"(1 + 20 t) e^(-20 t) leaves {21 * exp(-20.0):.0e} of it"
    yield near("place at rest [m]", end.p_WB[0], (0.0, 0.0, -sag), 1e-4, because)
    yield near("velocity at rest [m/s]", end.v_WB[0], np.zeros(3), 1e-4, "and so does its velocity")
    yield aligned("attitude [rad]", end.q_WB[0], UPRIGHT, 1e-6, "nothing turns it")
