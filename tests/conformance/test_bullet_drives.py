"""Springs and drives on Bullet: stiff arms against an independent integration, and the mobility that the implicit law needs."""

import math
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Diverged, Settings
from plumbline.harness.case.starts import member
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    Drive,
    Fixed,
    Joint,
    PlacedShape,
    Prismatic,
    Revolute,
    Scene,
    Spring,
    Surface,
    Vector3,
    axis_angle,
    box_inertia,
)
from plumbline.harness.study import plugins
from plumbline.harness.study.foreseen_cost import scene_at
from plumbline.harness.trajectory import State

pybullet = pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

G = 9.81
TRACKS = {name: replace(s, options={**s.options, "damping": "scene"}) for name, s in ADAPTER.tracks.items()}
"""Both tracks, without the damping that the vendor's defaults add: it is no part of the drive's law."""
LENGTHS, MASSES, THICK = np.array([0.4, 0.35, 0.25]), np.array([3.0, 2.0, 1.0]), 0.03
TARGETS = np.array([0.5, -0.6, 0.4])
STIFFNESS, DAMPING = 200.0, 20.0
STARTS = 16
"""Of an ensemble, as `limits` has it."""


def passed(scene: Scene, settings: Settings, *times: float) -> list[np.ndarray[Any, Any]]:
    """The centres of mass (n, 3) m at each of these times [s] of one run, in their order."""
    simulation = ADAPTER.build(scene, settings)
    try:
        here, places = 0, []
        for time in times:
            simulation.step(round(time / settings.dt) - here)
            here = round(time / settings.dt)
            state = State.empty(len(scene.bodies))
            simulation.state(state)
            places.append(state.p_WB)
        return places
    finally:
        simulation.close()


def placed(scene: Scene, settings: Settings, duration: float) -> np.ndarray[Any, Any]:
    """The centres of mass (n, 3) m at the end."""
    return passed(scene, settings, duration)[0]


def arm(kind: str) -> Scene:
    """Three links held out level by hinges about y, which springs or drives pull to TARGETS."""
    bodies, joints, reach, above = [], list[Joint](), 0.0, WORLD
    for k, (length, mass, target) in enumerate(zip(LENGTHS.tolist(), MASSES.tolist(), TARGETS.tolist(), strict=True)):
        half = (length / 2, THICK, THICK)
        shape = PlacedShape(shape=Box(half_extents=(length / 2 - 0.02, THICK, THICK)))
        bodies.append(
            Body(
                name=f"link_{k}",
                mass=mass,
                inertia=box_inertia(mass, half),
                p_WB=(reach + length / 2, 0.0, 0.0),
                material="link",
                collision=(shape,),
            )
        )
        pulled: dict[str, Any] = {"spring": Spring(stiffness=STIFFNESS, damping=DAMPING, rest=target)}
        if kind != "spring":
            limit = 15.0 if kind == "limited drive" else None
            pulled = {"drive": Drive(stiffness=STIFFNESS, damping=DAMPING, target=target, limit=limit)}
        anchor = (reach, 0.0, 0.0)
        joints.append(
            Revolute(name=f"j{k}", parent=above, child=f"link_{k}", anchor_W=anchor, axis_W=(0.0, 1.0, 0.0), **pulled)
        )
        reach, above = reach + length, f"link_{k}"
    return Scene(bodies=tuple(bodies), joints=tuple(joints), surfaces=(Surface(between=("link", "link")),))


def arm_truth(kind: str, duration: float) -> np.ndarray[Any, Any]:
    """The centres of mass (3, 3) m by Lagrange's equations in the angles below the horizontal, integrated by LSODA.

    With centre i at sum_j A_ij u(th_j), C = A^T m A and D_ij = th_i - th_j: (C cos D + I) th'' = Q - C sin D th'^2 - dV/dth.
    """
    A = np.tril(np.tile(LENGTHS, (3, 1)), -1) + np.diag(LENGTHS / 2)
    C, inertia = A.T @ (MASSES[:, None] * A), np.diag(MASSES / 3 * ((LENGTHS / 2) ** 2 + THICK**2))
    limit = 15.0 if kind == "limited drive" else math.inf

    def rate(_: float, y: Any) -> Any:
        angle, turned = np.cumsum(y[:3]), np.cumsum(y[3:])
        between = angle[:, None] - angle
        torque = np.clip(STIFFNESS * (TARGETS - y[:3]) - DAMPING * y[3:], -limit, limit)
        pull = torque - np.append(torque[1:], 0.0) + MASSES @ A * G * np.cos(angle) - (C * np.sin(between)) @ turned**2
        return np.concatenate((y[3:], np.diff(np.linalg.solve(C * np.cos(between) + inertia, pull), prepend=0.0)))

    run = solve_ivp(rate, (0.0, duration), np.zeros(6), "LSODA", rtol=1e-10, atol=1e-12)
    angle = np.cumsum(run.y[:3, -1])
    centre: np.ndarray[Any, Any] = A @ np.stack((np.cos(angle), 0 * angle, -np.sin(angle)), axis=1)
    return centre


@pytest.mark.parametrize("track", ["default", "tuned"])
@pytest.mark.parametrize("kind", ["drive", "spring", "limited drive"])
def test_a_stiff_arm_converges_to_an_independent_integration(kind: str, track: str) -> None:
    duration = 0.1
    truth = arm_truth(kind, duration)
    steps = (1 / 240, 1e-3, 2.5e-4)
    errors = [np.abs(placed(arm(kind), TRACKS[track].with_dt(dt), duration) - truth).max() for dt in steps]
    # A first-order law that is held over a step lags by a step: the speeds of up to 1 m/s, times dt, whatever dt h is.
    assert all(error < dt for error, dt in zip(errors, steps, strict=True))
    # And in proportion to the step: a factor of 4.2 and of 4, a third off for the next order.
    assert errors[0] / errors[1] == pytest.approx(1e3 / 240, rel=0.33)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.33)


@pytest.mark.parametrize("track", [pytest.param("default", marks=pytest.mark.slow), "tuned"])
def test_a_stiff_arm_that_presses_on_a_table_comes_to_rest_at_any_step(track: str) -> None:
    free = arm("drive")
    slab = PlacedShape(shape=Box(half_extents=(1.0, 1.0, 0.4)))
    table = Body(name="table", motion="static", material="table", p_WB=(0.6, 0.0, -0.7), collision=(slab,))
    laws = [Surface(between=pair, static_friction=0.5, kinetic_friction=0.5) for pair in (("link", "link"), ("table", "link"))]
    scene = replace(free, bodies=(*free.bodies, table), surfaces=tuple(laws))
    heights = []
    for dt in (1 / 240, 1e-3, 2.5e-4):
        first, later = passed(scene, TRACKS[track].with_dt(dt), 1.5, 2.0)
        # At rest: what is left of the first blows, exp(-(k/c) t) = exp(-15), of their decimetres.
        assert np.abs(later - first).max() < 1e-6
        heights.append(later[2, 2])
    # The tip lies on the table under the last link; friction holds it where it slid to, which no two steps tell alike: mu N
    # over the stiffness of the arm at the tip, k/l^2, is a centimetre along the table.
    assert np.ptp(heights) < 0.01


def test_the_efforts_of_the_start_stay_where_they_are_stable() -> None:
    """An undamped spring that the step resolves must not be damped by the law: it swings for ever."""
    body = Body(name="body", mass=2.0, p_WB=(0.1, 0.0, 0.0))
    spring = Spring(stiffness=200.0)
    joint = Prismatic(
        name="j", parent=WORLD, child="body", anchor_W=(0, 0, 0), axis_W=(1.0, 0.0, 0.0), position=0.1, spring=spring
    )
    scene = Scene(bodies=(body,), joints=(joint,), gravity=(0.0, 0.0, 0.0))
    dt, period = 1e-3, 2 * math.pi / 10
    # Semi-implicit Euler keeps the amplitude to w dt/2 = 0.5 %; a linearly implicit law would leave exp(-w^2 dt t/2) = 4 %.
    eighths = (100 * period + k * period / 8 for k in range(8))
    furthest = max(place[0, 0] for place in passed(scene, TRACKS["tuned"].with_dt(dt), *eighths))
    assert furthest == pytest.approx(0.1, rel=0.01)


def drawn(draw: np.random.Generator, base: str) -> Scene:
    """A tree of six bodies at random, one joint told from child to parent, all its hinges and slides stiffly driven."""

    def vector() -> Vector3:
        x, y, z = draw.normal(size=3).tolist()
        return (x, y, z)

    def tensor() -> Any:
        R = rotation(axis_angle(vector(), 1.0))
        return tuple(map(tuple, (R @ np.diag(draw.uniform(0.1, 0.2, 3)) @ R.T).tolist()))

    bodies = [
        Body(
            name=f"b{k}",
            mass=float(draw.uniform(0.5, 2)),
            inertia=tensor(),
            q_WB=axis_angle(vector(), 1.0),
            p_WB=vector(),
        )
        for k in range(6)
    ]
    if base == "kinematic":
        bodies[0] = replace(bodies[0], motion="kinematic")
    drive = Drive(stiffness=1e5, damping=1e4)
    joints: list[Joint] = [
        Ball(name="cup", parent="b0", child="b1", anchor_W=vector()),
        Revolute(name="hinge", parent="b1", child="b2", anchor_W=vector(), axis_W=vector(), drive=drive),
        Prismatic(name="slide", parent="b2", child="b3", anchor_W=vector(), axis_W=vector(), drive=drive),
        Fixed(name="weld", parent="b1", child="b4"),
        Revolute(name="back", parent="b5", child="b4", anchor_W=vector(), axis_W=vector(), drive=drive),
    ]
    if base == "world":
        joints.append(Revolute(name="foot", parent=WORLD, child="b0", anchor_W=vector(), axis_W=vector(), drive=drive))
    return Scene(bodies=tuple(bodies), joints=tuple(joints), gravity=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("base", ["world", "free", "kinematic"])
def test_the_mobility_of_a_trees_joints_is_what_bullet_answers_to_unit_efforts(base: str) -> None:
    scene, dt = drawn(np.random.default_rng(3), base), 1e-4
    answers, mobility = [], np.zeros((0, 0))
    for pushed in range(4 if base == "world" else 3):
        simulation: Any = ADAPTER.build(scene, TRACKS["tuned"].with_dt(dt))
        try:
            port = simulation._port
            ((number, actuation),) = simulation._made.actuators.items()
            mobility = actuation.skeleton.response(port, number, scene.gravity)[0]
            links = [actuator.link for actuator in actuation.actuators]
            efforts = np.eye(len(links))[pushed].tolist()
            port.call("setJointMotorControlArray", number, links, pybullet.TORQUE_CONTROL, forces=efforts)
            port.call("stepSimulation")
            answers.append([state[1] / dt for state in port.call("getJointStates", number, links)])
        finally:
            simulation.close()
    # From rest one step gives the accelerations themselves; Bullet's link poses go through its own quaternions, good to 1e-7.
    assert mobility == pytest.approx(np.array(answers).T, abs=1e-6 * np.abs(mobility).max())


def test_a_stiffly_driven_machine_without_a_base_keeps_its_momentum() -> None:
    scene = drawn(np.random.default_rng(5), "free")
    mass = np.array([body.mass for body in scene.bodies])
    start = mass @ State.initial(scene).p_WB / mass.sum()
    driven = tuple(
        replace(joint, drive=replace(joint.drive, target=0.3))
        if isinstance(joint, Revolute | Prismatic) and joint.drive
        else joint
        for joint in scene.joints
    )
    got = placed(replace(scene, joints=driven), TRACKS["tuned"].with_dt(1e-3), 0.2)
    # Nothing acts from outside, so that the common centre of mass stays; joint coordinates integrated to first order move it by
    # v^2 dt a second, 1e-3 at the metre per second that drives of 1e5 N m/rad reach at once.
    assert mass @ got / mass.sum() == pytest.approx(start, abs=1e-3)


def test_a_machine_whose_drives_have_no_solution_has_diverged_and_is_no_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bodies at 1e30 m/s leave the drives a singular system; here it is one from the first step on."""

    def singular(*_: object) -> Any:
        return np.linalg.solve(np.zeros((1, 1)), np.zeros(1))

    monkeypatch.setattr("plumbline.adapters.bullet.drives.Actuation.efforts", singular)
    case = plugins.case("stand_quadruped")
    simulation = ADAPTER.build(case.scene(case.parameters), TRACKS["tuned"])
    with closing(simulation), pytest.raises(Diverged, match="no solution"):
        simulation.step()


def test_a_quadruped_on_stiff_drives_stands_from_every_start_of_its_ensemble() -> None:
    """At the start drives bear what they exert there. With the least share of gravity in its place one start flies off."""
    case = plugins.case("stand_quadruped")
    scene, dt = scene_at(case, {"stiffness": 8e4}), 1 / 240
    settings = ADAPTER.tracks["tuned"].with_dt(dt)
    fastest = []
    for number in range(STARTS):
        start = member(scene, number, dt).scene
        simulation, end = ADAPTER.build(start, settings), State.empty(len(start.bodies))
        with closing(simulation):
            simulation.step(240)
            simulation.state(end)
        fastest.append(float(np.abs(end.v_WB).max()))
    assert max(fastest) < G * dt, "g dt is what one step of gravity gives"


def test_bullets_own_motor_comes_to_rest_where_stiffness_and_damping_balance() -> None:
    """k (x0 - x) + c u = 0 has no step in it: x = .1 + 60 * .5 / 200, after twenty time constants c/k."""
    drive = Drive(stiffness=200.0, damping=60.0, target=0.1, target_velocity=0.5)
    slide = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0), drive=drive)
    scene = Scene(bodies=(Body(name="body"),), joints=(slide,), gravity=(0.0, 0.0, 0.0))
    for dt in (1 / 60, 1 / 240):
        settings = replace(TRACKS["default"].with_dt(dt), options={"drives": "motor"})
        simulation, end = ADAPTER.build(scene, settings), State.empty(1)
        with closing(simulation):
            simulation.step(round(6.0 / dt))
            simulation.state(end)
        assert end.p_WB[0, 0] == pytest.approx(0.25, abs=1e-6), dt
