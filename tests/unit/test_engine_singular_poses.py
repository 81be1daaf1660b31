"""Loops in poses where their constraints lose a rank: they go through them, start in them, and keep their energy and branch."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine
from tests.loops import bennett

INERTIA, G = 0.02, 9.81
TRACKS = pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
GROUND = engine.Body(name="ground", motion="static", shapes=(engine.Placed(engine.Plane()),), p_WB=(0, 0, -5))
BALL = engine.Body(name="ball", inertia=0.01 * np.eye(3), shapes=(engine.Placed(engine.Sphere(0.1)),), p_WB=(5, 0, -4.9))
"""What lies on its own beside a loop, and has it solved as beside contacts."""
SOLVED = pytest.mark.parametrize(
    ("integrator", "beside"), [("rk4", ()), ("semi_implicit_euler", ()), ("semi_implicit_euler", (GROUND, BALL))],
    ids=["rk4", "shake", "contacts"],
)  # fmt: skip


def _energy(world: engine.World, masses: tuple[float, ...], gravity: float) -> float:
    s, m = world.state()[: len(masses)], np.array(masses)
    return float(m @ (s[:, 7:10] ** 2).sum(axis=1) / 2 + INERTIA * (s[:, 10:] ** 2).sum() / 2 + gravity * m @ s[:, 2])


@SOLVED
@pytest.mark.parametrize("phase", [0.0, 1e-9, 1e-6, 1e-3])
def test_a_crank_as_long_as_its_rod_takes_the_slider_through_its_foot(
    phase: float, integrator: str, beside: tuple[engine.Body, ...]
) -> None:
    """Upright, crank and rod cover each other, and could go on turning with the slider at rest; the twentieth step ends there,
    but for a phase. By momentum the slider goes on: x = 2 l cos(angle), to round-off for Runge-Kutta and SHAKE, and beside
    contacts to what a turn of w h opens, (w h)^2 / 2 = 2e-6 of a lever. Energy: (w dt)^4 / 120 for Runge-Kutta, w h for others.
    """
    length, rate, start = 0.5, 5.0, math.pi / 2 - 0.1 - phase
    s, c = length * math.sin(start), length * math.cos(start)
    knee, end, turn = np.array((c, 0, s)), np.array((2 * c, 0, 0)), np.array((0, -rate, 0))
    v_knee, v_end = np.cross(turn, knee), np.array((-2 * s * rate, 0, 0))
    bodies = [
        engine.Body(name="crank", inertia=INERTIA * np.eye(3), p_WB=knee / 2, v_WB=v_knee / 2, w_WB=turn),
        engine.Body(name="rod", inertia=INERTIA * np.eye(3), p_WB=(knee + end) / 2, v_WB=(v_knee + v_end) / 2, w_WB=-turn),
        engine.Body(name="slider", inertia=INERTIA * np.eye(3), p_WB=end, v_WB=v_end),
    ]
    joints = [
        engine.Revolute(name="foot", parent=engine.WORLD, child="crank", anchor_W=(0, 0, 0), axis_W=(0, 1, 0)),
        engine.Revolute(name="knee", parent="crank", child="rod", anchor_W=knee, axis_W=(0, 1, 0)),
        engine.Revolute(name="pin", parent="rod", child="slider", anchor_W=end, axis_W=(0, 1, 0)),
        engine.Prismatic(name="rail", parent=engine.WORLD, child="slider", anchor_W=end, axis_W=(1, 0, 0)),
    ]
    options = engine.Options(integrator=integrator, dt=1e-3)
    world = engine.World([*bodies, *beside], joints, gravity=(0, 0, 0), options=options)
    before = _energy(world, (1.0, 1.0, 1.0), 0.0)
    for _ in range(60):
        world.step()
        state = world.state()
        x = 2 * length * math.cos(math.atan2(state[0, 2], state[0, 0]))
        assert state[2, 0] == pytest.approx(x, abs=1e-5 if beside else 1e-10)
        assert _energy(world, (1.0, 1.0, 1.0), 0.0) == pytest.approx(before, rel=1e-9 if integrator == "rk4" else 5e-3)
    assert math.atan2(state[0, 2], state[0, 0]) == pytest.approx(start + 0.3, abs=5e-3)


def _parallelogram(
    start: float, rate: float, masses: tuple[float, ...], integrator: str, beside: tuple[engine.Body, ...]
) -> engine.World:
    """Two cranks of .5 m, a metre apart, at an angle [rad] above the line of their feet, and the coupler of their ends."""
    tip, turn = 0.5 * np.array((math.cos(start), 0, math.sin(start))), np.array((0, -rate, 0))
    speed = np.cross(turn, tip)
    bodies = [
        engine.Body(
            name=f"crank{k}",
            mass=masses[k],
            inertia=INERTIA * np.eye(3),
            p_WB=tip / 2 + np.array((k, 0, 0)),
            v_WB=speed / 2,
            w_WB=turn,
        )
        for k in range(2)
    ]
    bodies.append(
        engine.Body(name="coupler", mass=masses[2], inertia=INERTIA * np.eye(3), p_WB=tip + np.array((0.5, 0, 0)), v_WB=speed)
    )
    joints = []
    for k in range(2):
        foot = np.array((k, 0.0, 0.0))
        ends = ((f"foot{k}", engine.WORLD, f"crank{k}", foot), (f"head{k}", f"crank{k}", "coupler", foot + tip))
        joints += [
            engine.Revolute(name=name, parent=parent, child=child, anchor_W=anchor, axis_W=(0, 1, 0))
            for name, parent, child, anchor in ends
        ]
    return engine.World([*bodies, *beside], joints, options=engine.Options(integrator=integrator, dt=2e-3))


@SOLVED
@pytest.mark.parametrize(
    ("start", "rate"), [(0.0, 0.0), (0.0, 3.0), (0.1, -5.0), (0.02, -0.3)], ids=["at rest", "moving", "fast", "slow"]
)
def test_a_parallelogram_stays_one_in_its_flat_pose(
    start: float, rate: float, integrator: str, beside: tuple[engine.Body, ...]
) -> None:
    """From it or through it, with one crank of three times the weight: as an anti-parallelogram its cranks would part.

    In one line a gap g lets them part by sqrt(8 g / l): of round-off, 1e-15 m, that is 1e-7; beside contacts, of (w h)^2 / 2 l
    at h = 5e-4 s, with w = 5/s, 5e-3. Energy: where it starts flat, the first step knows one row less; others: w h of 30 J.
    """
    masses = (1.0, 3.0, 1.0)
    world = _parallelogram(start, rate, masses, integrator, beside)
    before, furthest = _energy(world, masses, G), 0.0
    for _ in range(100):
        world.step()
        q = world.state()[:3, 3:7]
        turned = 2 * np.arctan2(q[:, 2], q[:, 0])
        assert abs(turned[0] - turned[1]) < (5e-3 if beside else 1e-5)
        assert abs(turned[2]) < (5e-3 if beside else 1e-5)
        assert _energy(world, masses, G) == pytest.approx(before, abs=1e-3 if integrator == "rk4" else 0.1)
        furthest = max(furthest, abs(turned[0]))
    assert furthest > 0.1


@SOLVED
def test_a_spatial_loop_with_constraints_too_many_keeps_its_energy(integrator: str, beside: tuple[engine.Body, ...]) -> None:
    """Bennett's linkage folds twice in 1.5 s. Its three redundant rows follow from the others where it is closed, and not in
    the stages of a step, which leave it by (w dt)^2 / 8 of a lever.

    Runge-Kutta: (w dt)^4 / 120 with w = 8/s at dt = 1e-3 is 3e-11 a radian; a fold costs digits, as above. Others: w h.
    """
    world = bennett(None, integrator, beside)
    before = _energy(world, (1.0, 1.0, 1.0), G)
    for _ in range(150):
        world.step(10)
        assert _energy(world, (1.0, 1.0, 1.0), G) == pytest.approx(before, abs=1e-6 if integrator == "rk4" else 0.1)
    turn = Rotation.from_quat(world.state()[0, 3:7], scalar_first=True).magnitude()
    assert turn > 1.0
