"""Joints in MuJoCo: coordinates, loops, limits, drives and damping."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Drive,
    Joint,
    Limits,
    Prismatic,
    Scene,
    Spring,
    Vector3,
    principal_inertia,
)
from plumbline.harness.trajectory import State
from tests.conformance.mujoco_scenes import BOTH, TUNED, G, built, hinge_at, matrix, state_of


def energy_of(scene: Scene, state: State) -> float:
    total = 0.0
    for k, body in enumerate(scene.bodies):
        if body.movable:
            w_B = matrix(state.q_WB[k]).T @ state.w_WB[k]
            turning = w_B @ np.array(body.inertia) @ w_B
            total += float(body.mass * state.v_WB[k] @ state.v_WB[k] + turning) / 2 + body.mass * G * float(state.p_WB[k, 2])
    return total


def rod_body(
    name: str, p: Vector3, axis: int, w: Vector3 = (0.0, 0.0, 0.0), v: Vector3 = (0.0, 0.0, 0.0), length: float = 1.0
) -> Body:
    moments = [length**2 / 12] * 3
    moments[axis] = 1e-4
    return Body(name=name, inertia=principal_inertia(*moments), p_WB=p, w_WB=w, v_WB=v)


def four_bars() -> Scene:
    """A parallelogram of cranks 1 m and a coupler of 2 m, turning at 1 rad/s."""
    bars = (
        rod_body("left", (0.0, 0.0, 0.5), 2, w=(0.0, 1.0, 0.0), v=(0.5, 0.0, 0.0)),
        rod_body("top", (1.0, 0.0, 1.0), 0, v=(1.0, 0.0, 0.0), length=2.0),
        rod_body("right", (2.0, 0.0, 0.5), 2, w=(0.0, 1.0, 0.0), v=(0.5, 0.0, 0.0)),
    )
    pins = ((WORLD, "left", (0, 0, 0)), ("left", "top", (0, 0, 1)), ("top", "right", (2, 0, 1)), (WORLD, "right", (2, 0, 0)))
    return Scene(bodies=bars, joints=tuple(hinge_at(f"{a}-{b}", a, b, p) for a, b, p in pins))


def test_damping_inside_a_chain_is_refused_and_on_a_single_hinge_exact() -> None:
    arm = Body(
        name="arm",
        mass=2.0,
        p_WB=(0.5, 0.0, 0.0),
        w_WB=(0.0, 1.0, 0.0),
        v_WB=(0.0, 0.0, -0.5),
        linear_damping=0.3,
        angular_damping=0.2,
    )
    scene = Scene(bodies=(arm,), joints=(hinge_at("j", WORLD, "arm", (0, 0, 0)),), gravity=(0.0, 0.0, 0.0))
    simulation = built(scene, TUNED)
    simulation.step(1000)
    # (I + m r^2) w' = -(c_w I + c_v m r^2) w with I = 1, m r^2 = 0.5.
    assert state_of(simulation, scene).w_WB[0, 1] == pytest.approx(math.exp(-(0.2 + 0.3 * 0.5) / 1.5), rel=1e-10)
    chain = Scene(
        bodies=(arm, Body(name="end", p_WB=(1.5, 0.0, 0.0), v_WB=(0.0, 0.0, -1.0), linear_damping=0.1)),
        joints=(*scene.joints, hinge_at("k", "arm", "end", (1, 0, 0))),
    )
    with pytest.raises(Unsupported, match=r"'end'.*damp"):
        built(chain)


@pytest.mark.parametrize("kind", ["revolute", "ball", "turned round"])
def test_a_pendulum_follows_its_equation_and_has_no_joint_gap(kind: str) -> None:
    rod = rod_body("rod", (0.5, 0.0, 0.0), 0, w=(0.0, 1.3, 0.0), v=(0.0, 0.0, -0.65))
    post = Body(name="post", motion="static")
    joint: Joint = hinge_at("j", "post", "rod", (0, 0, 0))
    if kind == "ball":
        joint = Ball(name="j", parent=WORLD, child="rod", anchor_W=(0.0, 0.0, 0.0))
    elif kind == "turned round":
        joint = hinge_at("j", "rod", "post", (0, 0, 0))
    scene = Scene(bodies=(rod, post), joints=(joint,))
    simulation = built(scene, TUNED)
    simulation.step(2000)
    end = state_of(simulation, scene)
    angle = solve_ivp(lambda _, y: (y[1], 1.5 * G * math.cos(y[0])), (0, 2), (0.0, 1.3), rtol=1e-12, atol=1e-12).y[0, -1]
    # RK4 at rate 6 / s: (w dt)^4 = 1e-9 over two seconds.
    np.testing.assert_allclose(end.p_WB[0], (0.5 * math.cos(angle), 0.0, -0.5 * math.sin(angle)), atol=1e-8)
    np.testing.assert_allclose(end.p_WB[0], matrix(end.q_WB[0]) @ (0.5, 0.0, 0.0), atol=1e-14)


def test_a_double_pendulum_keeps_its_energy_whatever_the_order_of_bodies_and_joints() -> None:
    bodies = (rod_body("upper", (0.0, 0.0, -0.5), 2), rod_body("lower", (0.5, 0.0, -1.0), 0))
    joints = (hinge_at("a", WORLD, "upper", (0, 0, 0)), hinge_at("b", "upper", "lower", (0, 0, -1)))
    ends = []
    for way in (1, -1):
        scene = Scene(bodies=bodies[::way], joints=joints[::way])
        simulation = built(scene, TUNED)
        start = energy_of(scene, state_of(simulation, scene))
        simulation.step(2000)
        end = state_of(simulation, scene)
        # RK4: (10 / s dt)^5 a step, 2000 steps, of 10 J.
        assert energy_of(scene, end) == pytest.approx(start, abs=1e-7)
        ends.append(end.p_WB[::way])
    np.testing.assert_array_equal(ends[0], ends[1])


def test_a_four_bar_loop_closes_to_micrometres() -> None:
    scene = four_bars()
    simulation = built(scene, TUNED)
    gap = 0.0
    for _ in range(100):
        simulation.step(10)
        now = state_of(simulation, scene)
        foot = now.p_WB[2] - matrix(now.q_WB[2]) @ (0.0, 0.0, 0.5)
        gap = max(gap, float(np.abs(foot - (2.0, 0.0, 0.0)).max()))
    # Impedance .999, time constant 2 dt: the gap is (1 - d) a (2 dt)^2, 2e-7 m for a below 50 m/s2; tenfold is granted.
    assert 0 < gap < 2e-6


def test_velocities_that_a_joint_forbids_are_refused() -> None:
    scene = four_bars()
    still = tuple(replace(b, v_WB=(0.0, 0.0, 0.0), w_WB=(0.0, 0.0, 0.0)) if b.name == "right" else b for b in scene.bodies)
    with pytest.raises(Unsupported, match="velocit"):
        built(replace(scene, bodies=still))
    rod = Distance(name="d", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="velocit"):
        built(Scene(bodies=(Body(name="b", p_WB=(1.0, 0.0, 0.0), v_WB=(1.0, 0.0, 0.0)),), joints=(rod,)))


def test_a_slide_counts_from_its_position_towards_its_spring() -> None:
    spring = Spring(stiffness=50.0, damping=2.0, rest=0.1)
    slide = Prismatic(
        name="j", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 1.0), axis_W=(1.0, 0.0, 0.0), position=0.3, spring=spring
    )
    scene = Scene(bodies=(Body(name="b", mass=2.0, p_WB=(0.0, 0.0, 1.0)),), joints=(slide,))
    simulation = built(scene, TUNED)
    simulation.step(1000)
    w, z = 5.0, 0.1
    w_d = w * math.sqrt(1 - z * z)
    x = 0.1 + 0.2 * math.exp(-z * w) * (math.cos(w_d) + z * w / w_d * math.sin(w_d))
    assert simulation.resolved.integrator == "rk4"
    assert state_of(simulation, scene).p_WB[0, 0] + 0.3 == pytest.approx(x, abs=1e-9)


@BOTH
def test_a_drive_reaches_its_target_stops_at_limits_and_is_cut_off(settings: Settings) -> None:
    body = Body(name="b", inertia=principal_inertia(0.1, 0.1, 0.1))
    drive = Drive(stiffness=20.0, damping=3.0, target=0.5)
    scene = Scene(
        bodies=(body,), joints=(hinge_at("j", WORLD, "b", (0, 0, 0), position=-0.2, limits=Limits(upper=2.0), drive=drive),)
    )
    simulation = built(scene, settings)

    def angle() -> float:
        q = state_of(simulation, scene).q_WB[0]
        return 2 * math.atan2(q[2], q[0]) - 0.2

    simulation.step(3000)
    assert angle() == pytest.approx(0.5, abs=1e-6)
    simulation.command({"j": 3.0})
    simulation.step(3000)
    # A soft stop under 20 N m on 0.1 kg m2: (1 - d) a tc^2 ratio^2 = 0.1 * 200 * 4e-4, doubled for d below .95.
    assert 2.0 <= angle() < 2.016
    with pytest.raises(ValueError, match="'k' has no drive"):
        simulation.command({"k": 1.0})
    weak = replace(drive, stiffness=1e4, limit=0.7)
    scene = Scene(bodies=(body,), joints=(hinge_at("j", WORLD, "b", (0, 0, 0), drive=weak),))
    simulation = built(scene, settings)
    simulation.step(50)
    assert state_of(simulation, scene).w_WB[0, 1] == pytest.approx(0.7 * 0.05 / 0.1, rel=1e-9)


def test_distance_joints_hold_limit_or_spring() -> None:
    body = Body(name="b", p_WB=(1.0, 0.0, 0.0))
    span = {}
    for kind, extra in {
        "rod": {},
        "rope": {"limits": Limits(upper=1.2)},
        "spring": {"spring": Spring(stiffness=40.0, rest=1.0)},
    }.items():
        joint = Distance(name="d", parent=WORLD, child="b", anchor_W=(0.0, 0.0, 0.0), child_anchor_W=(1.0, 0.0, 0.0), **extra)  # type: ignore[arg-type]
        scene = Scene(bodies=(body,), joints=(joint,))
        simulation = built(scene, TUNED)
        length = []
        for _ in range(100):
            simulation.step(10)
            length.append(float(np.linalg.norm(state_of(simulation, scene).p_WB[0])))
        span[kind] = (min(length), max(length))
        if kind == "spring":
            energy = energy_of(scene, state_of(simulation, scene)) + 20 * (length[-1] - 1) ** 2
            assert energy == pytest.approx(0.0, abs=1e-9)
    assert span["rod"] == pytest.approx((1.0, 1.0), abs=1e-4)
    # The rope catches 5 m/s softly: it gives way by about v tc / e with tc = 20 dt.
    assert span["rope"][0] < 1.1
    assert 1.2 <= span["rope"][1] < 1.2 + 5 * 0.02
    assert span["spring"][1] > 1.1


def test_a_stop_is_passed_by_less_than_a_step_and_the_limit_is_no_softer_than_its_own_settings_say() -> None:
    """A rod swings down into a stop: by its own `limit_steps`, whatever contacts are told."""
    inertia = principal_inertia(1 / 12, 1 / 12, 1e-3)
    rod = Body(name="rod", inertia=inertia, p_WB=(0.0, 0.0, -0.5), w_WB=(0.0, 4.0, 0.0), v_WB=(-2.0, 0.0, 0.0))
    scene = Scene(bodies=(rod,), joints=(hinge_at("j", WORLD, "rod", (0, 0, 0), limits=Limits(upper=0.3)),))
    for dt in (1 / 240, 1e-3):
        simulation, beyond = built(scene, TUNED, dt), 0.0
        for _ in range(round(0.4 / dt)):
            simulation.step()
            q = state_of(simulation, scene).q_WB[0]
            beyond = max(beyond, 2 * math.atan2(q[2], q[0]) - 0.3)
        # Noticed once it is passed, it is passed by at most a step's way at 4 rad/s; the damping takes what is left of a step.
        assert 0.0 < beyond < 1.25 * 4.0 * dt
        assert simulation.resolved.options["limit_time_constant"] == pytest.approx(2 * dt)


def test_loops_that_no_constraint_of_the_engine_closes_are_refused() -> None:
    bodies = tuple(rod_body(name, (float(k), 0.0, 0.0), 0) for k, name in enumerate("ab"))
    slides = tuple(
        Prismatic(name=f"{a}-{b}", parent=a, child=b, anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0))
        for a, b in ((WORLD, "a"), ("a", "b"), (WORLD, "b"))
    )
    with pytest.raises(Unsupported, match="prismatic joint that closes a loop"):
        built(Scene(bodies=bodies, joints=slides))
