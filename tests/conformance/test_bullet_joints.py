"""Joints in Bullet: trees, loops, drives and limits of its multibodies."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Unsupported
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Drive,
    Fixed,
    Joint,
    Limits,
    Prismatic,
    Revolute,
    Scene,
    Spring,
    axis_angle,
    principal_inertia,
)
from plumbline.harness.trajectory import State

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")
from tests.conformance.bullet_scenes import NOWHERE, TUNED, TURNED, G, ball, built, law, state_of, tensor


def vector(numbers: Any) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in numbers)
    return (x, y, z)


def chain(reverse: bool) -> Scene:
    """Five bodies with every kind of joint between them, in motion, the scene's order unlike the tree's."""
    w_A, w_C = np.array([0.3, 0.4, -0.2]), np.array([1.0, -2.0, 0.5])
    w_B = w_A + 1.5 * np.array([0.0, 0.6, 0.8])
    p = {"A": (0, 0, 0), "B": (0.9, 0.3, 0.2), "C": (1.5, 0.2, 0.7), "D": (2.0, 0.1, 0.3), "E": (2.0, 0.1, 0.6)}
    at = {name: np.array(place, dtype=float) for name, place in p.items()}
    pin, cup, axis = np.array([0.4, 0.1, 0.0]), np.array([1.2, 0.3, 0.5]), np.array([1.0, 2.0, 2.0]) / 3
    v_A = np.array([0.2, 0.0, 0.1])
    v_B = v_A + np.cross(w_A, pin - at["A"]) + np.cross(w_B, at["B"] - pin)
    v_C = v_B + np.cross(w_B, cup - at["B"]) + np.cross(w_C, at["C"] - cup)
    v_D = v_C + np.cross(w_C, at["D"] - at["C"]) + 0.7 * axis
    v_E = v_D + np.cross(w_C, at["E"] - at["D"])
    motion = {"A": (v_A, w_A), "B": (v_B, w_B), "C": (v_C, w_C), "D": (v_D, w_C), "E": (v_E, w_C)}
    bodies = {
        name: Body(
            name=name,
            mass=1.0 + k / 4,
            inertia=tensor(0.3, 0.5, 0.6),
            q_WB=axis_angle((1.0, k, 2.0), 0.4 * k),
            p_WB=vector(at[name]),
            v_WB=vector(v),
            w_WB=vector(w),
        )
        for k, (name, (v, w)) in enumerate(motion.items())
    }

    forwards: tuple[Joint, ...] = (
        Revolute(name="pin", parent="A", child="B", anchor_W=vector(pin), axis_W=(0.0, 0.6, 0.8)),
        Ball(name="cup", parent="B", child="C", anchor_W=vector(cup)),
        Prismatic(name="slide", parent="C", child="D", anchor_W=(1.7, 0.3, 0.5), axis_W=vector(axis)),
        Fixed(name="weld", parent="D", child="E"),
    )
    joints = tuple(replace(j, parent=j.child, child=j.parent) for j in forwards) if reverse else forwards
    return Scene(bodies=tuple(bodies[name] for name in "CAEDB"), joints=joints, gravity=NOWHERE)


@pytest.mark.parametrize("reverse", [False, True], ids=["parent to child", "child to parent"])
def test_a_moving_tree_of_all_joints_starts_where_the_scene_says(reverse: bool) -> None:
    scene = chain(reverse)
    with built(scene, TUNED) as simulation:
        got = state_of(simulation, scene)
    wanted = State.initial(scene)
    for name in ("p_WB", "v_WB", "w_WB"):
        assert getattr(got, name) == pytest.approx(getattr(wanted, name), abs=1e-12), name
    assert np.abs((got.q_WB * wanted.q_WB).sum(axis=1)) == pytest.approx(np.ones(5), abs=1e-12)


def test_a_free_tree_keeps_its_momenta_to_first_order_in_the_step() -> None:
    scene = chain(reverse=False)

    def momenta(state: State) -> np.ndarray[Any, Any]:
        linear, angular = np.zeros(3), np.zeros(3)
        for k, body in enumerate(scene.bodies):
            R = rotation(state.q_WB[k])
            linear += body.mass * state.v_WB[k]
            angular += R @ np.asarray(body.inertia) @ R.T @ state.w_WB[k] + body.mass * np.cross(state.p_WB[k], state.v_WB[k])
        return np.concatenate((linear, angular))

    drift = []
    for dt in (2e-3, 1e-3):
        with built(scene, TUNED.with_dt(dt)) as simulation:
            before = momenta(state_of(simulation, scene))
            simulation.step(round(0.2 / dt))
            drift.append(np.abs(momenta(state_of(simulation, scene)) - before).max())
    # Joint coordinates integrated to first order: half the step, half the drift; a false frame would leave it as it is.
    assert drift[1] == pytest.approx(drift[0] / 2, rel=0.1)


def test_velocities_that_a_joint_forbids_are_refused() -> None:
    body = Body(name="bob", p_WB=(1.0, 0.0, 0.0), v_WB=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="misses what its joints allow"):
        ADAPTER.build(Scene(bodies=(body,), joints=(Ball(name="j", parent=WORLD, child="bob", anchor_W=NOWHERE),)), TUNED)


@pytest.mark.parametrize("kind", ["revolute", "ball"])
def test_a_pendulum_keeps_its_energy_on_tuned(kind: str) -> None:
    body = Body(name="bob", mass=2.0, inertia=tensor(0.3, 0.5, 0.6), q_WB=TURNED, p_WB=(0.7, 0.0, 0.0))
    joint: Joint = Ball(name="j", parent=WORLD, child="bob", anchor_W=NOWHERE)
    if kind == "revolute":
        joint = Revolute(name="j", parent=WORLD, child="bob", anchor_W=NOWHERE, axis_W=(0.0, 1.0, 0.0))
    scene = Scene(bodies=(body,), joints=(joint,))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        energies = []
        for _ in range(100):
            simulation.step(50)
            s = state_of(simulation, scene)
            R = rotation(s.q_WB[0])
            I_W = R @ np.asarray(body.inertia) @ R.T
            energies.append(s.v_WB[0] @ s.v_WB[0] + 0.5 * s.w_WB[0] @ I_W @ s.w_WB[0] + 2.0 * G * s.p_WB[0, 2])
    # m g l = 13.7 J. v lags by half a step, dE <= m g v dt/2 = 0.03 J; a ball joint's frame adds as much again in first order.
    assert np.abs(energies).max() < 0.1
    # A damping of 0.04 1/s would take more than 4 J in these 5 s.
    assert np.mean(energies[-20:]) > -0.1


@pytest.mark.parametrize("ends", [("a", "c"), ("a", "b")], ids=["unjoined links", "joined links that may collide"])
def test_links_of_one_tree_collide_unless_their_joint_forbids_it(ends: tuple[str, str]) -> None:
    """Two overlapping balls in a tree: they are pushed apart exactly if the scene lets them touch."""
    names, places = ("a", "b", "c"), {"a": 0.0, "b": 5.0, "c": 5.0} | dict(zip(ends, (0.0, 0.15), strict=True))
    bodies = tuple(ball(name=name, p_WB=(places[name], 0.0, 0.0)) for name in names)
    for collide in (True, False):
        joints = tuple(
            Prismatic(
                name=p + c, parent=p, child=c, anchor_W=NOWHERE, axis_W=(1.0, 0.0, 0.0), collide=collide and (p, c) == ends
            )
            for p, c in (("a", "b"), ("b", "c"))
        )
        scene = Scene(bodies=bodies, joints=joints, surfaces=(law(pair=("solid", "solid")),), gravity=NOWHERE)
        with built(scene, TUNED) as simulation:
            simulation.step(120)
            got = state_of(simulation, scene).p_WB[:, 0]
        gap = abs(got[names.index(ends[0])] - got[names.index(ends[1])])
        touching = collide or ends == ("a", "c")
        # What pushes them apart may leave them flying.
        assert gap > 0.199 if touching else gap == pytest.approx(0.15, abs=1e-12)


def test_a_four_bar_loop_stays_closed_and_keeps_its_energy() -> None:
    I = principal_inertia(0.1, 0.1, 0.1)  # noqa: E741 -- the name of an inertia
    bars = (
        Body(name="left", inertia=I, p_WB=(0.0, 0.0, 0.5), v_WB=(0.5, 0.0, 0.0), w_WB=(0.0, 1.0, 0.0)),
        Body(name="top", inertia=I, p_WB=(0.5, 0.0, 1.0), v_WB=(1.0, 0.0, 0.0)),
        Body(name="right", inertia=I, p_WB=(1.0, 0.0, 0.5), v_WB=(0.5, 0.0, 0.0), w_WB=(0.0, 1.0, 0.0)),
    )
    pins = ((WORLD, "left", (0, 0, 0)), ("left", "top", (0, 0, 1)), ("top", "right", (1, 0, 1)), (WORLD, "right", (1, 0, 0)))
    joints = tuple(Revolute(name=f"{a}-{b}", parent=a, child=b, anchor_W=p, axis_W=(0.0, 1.0, 0.0)) for a, b, p in pins)
    scene = Scene(bodies=bars, joints=joints)
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        for _ in range(20):
            simulation.step(50)
            s = state_of(simulation, scene)
            tips = [
                s.p_WB[k] + rotation(s.q_WB[k]) @ d
                for k, d in ((0, (0, 0, 0.5)), (1, (-0.5, 0, 0)), (1, (0.5, 0, 0)), (2, (0, 0, 0.5)))
            ]
            foot = s.p_WB[2] + rotation(s.q_WB[2]) @ (0, 0, -0.5)
            # Speeds of 4 m/s turn by 4e-3 rad a step: a constraint met to first order leaves at most (w dt)^2 l = 1.6e-5 m.
            assert np.abs(tips[0] - tips[1]).max() < 2e-5
            assert np.abs(tips[2] - tips[3]).max() < 2e-5
            assert np.abs(foot - (1, 0, 0)).max() < 2e-5
            energy = sum(0.5 * v @ v + 0.05 * w @ w + G * p[2] for p, v, w in zip(s.p_WB, s.v_WB, s.w_WB, strict=True))
            # v lags by half a step: dE <= (sum of m) g v dt/2 = 3 * 9.81 * 5 * 5e-4.
            assert energy == pytest.approx(20.47, abs=0.08)


@pytest.mark.parametrize("flip", [1.0, -1.0], ids=["forwards", "backwards"])
def test_a_spring_and_damper_is_in_newtons_per_metre(flip: float) -> None:
    m, k, c, dt = 2.0, 50.0, 2.0, 1e-4
    spring = Spring(stiffness=k, damping=c, rest=0.1 * flip)
    body = Body(name="body", mass=m, inertia=tensor(0.3, 0.5, 0.6), q_WB=TURNED, p_WB=(0.3, 0.0, 0.0))
    joint = Prismatic(
        name="j",
        parent=WORLD,
        child="body",
        anchor_W=(0.1, 0.0, 0.2),
        axis_W=(flip, 0.0, 0.0),
        position=0.3 * flip,
        spring=spring,
    )
    scene = Scene(bodies=(body,), joints=(joint,), gravity=NOWHERE)
    with built(scene, TUNED.with_dt(dt)) as simulation:
        simulation.step(10_000)
        got = state_of(simulation, scene).p_WB[0, 0]
    decay, w = c / (2 * m), math.sqrt(k / m - (c / (2 * m)) ** 2)
    expected = 0.1 + 0.2 * math.exp(-decay) * (math.cos(w) + decay / w * math.sin(w))
    # Staggered by half a step at 1 m/s: 5e-5 m.
    assert got == pytest.approx(expected, abs=5e-5)


@pytest.mark.parametrize("child", ["arm", "post"], ids=["arm is the child", "arm is the parent"])
def test_a_drive_reaches_its_targets_with_the_sign_of_the_joint(child: str) -> None:
    arm = Body(name="arm", mass=2.0, inertia=principal_inertia(0.3, 0.3, 0.3), p_WB=(0.5, 0.0, 0.0))
    post = Body(name="post", motion="static")
    sign = 1.0 if child == "arm" else -1.0
    joint = Revolute(
        name="j",
        parent="post" if child == "arm" else "arm",
        child=child,
        anchor_W=NOWHERE,
        axis_W=(0.0, 0.0, 1.0),
        position=0.2,
        drive=Drive(stiffness=40.0, damping=10.0, target=1.2),
    )
    scene = Scene(bodies=(arm, post), joints=(joint,))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        for target in (1.2, 0.4):
            simulation.command({"j": target})
            simulation.step(5000)
            p = state_of(simulation, scene).p_WB[0]
            # Critically damped at about 7 1/s: exp(-35) is left after 5 s.
            assert math.atan2(p[1], p[0]) == pytest.approx(sign * (target - 0.2), abs=1e-9)


def test_a_drive_pulls_no_harder_than_its_limit() -> None:
    body = Body(name="body", mass=2.0)
    drive = Drive(stiffness=1e6, damping=0.0, target=100.0, limit=3.0)
    joint = Prismatic(name="j", parent=WORLD, child="body", anchor_W=NOWHERE, axis_W=(1.0, 0.0, 0.0), drive=drive)
    scene = Scene(bodies=(body,), joints=(joint,), gravity=NOWHERE)
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(100)
        assert state_of(simulation, scene).v_WB[0, 0] == pytest.approx(3.0 / 2.0 * 0.1, abs=1e-12)


@pytest.mark.parametrize(("lower", "upper"), [(-1.0, 0.7), (None, 0.7)])
def test_a_limit_counts_from_the_joints_position_and_may_be_one_sided(lower: float | None, upper: float) -> None:
    body = Body(name="body", mass=2.0, inertia=principal_inertia(0.3, 0.3, 0.3), p_WB=(0.5, 0.0, 0.0))
    joint = Revolute(
        name="j",
        parent=WORLD,
        child="body",
        anchor_W=NOWHERE,
        axis_W=(0.0, 1.0, 0.0),
        position=0.2,
        limits=Limits(lower=lower, upper=upper),
    )
    scene = Scene(bodies=(body,), joints=(joint,))
    with built(scene, TUNED) as simulation:
        simulation.step(960)
        p = state_of(simulation, scene).p_WB[0]
    assert math.atan2(-p[2], p[0]) + 0.2 == pytest.approx(upper, abs=1e-6)


def test_loaded_and_sliding_joints_do_not_close_loops_and_distances_are_refused() -> None:
    a, b = Body(name="a"), Body(name="b", p_WB=(1.0, 0.0, 0.0))
    slides = tuple(
        Prismatic(name=f"j{k}", parent=p, child=c, anchor_W=NOWHERE, axis_W=(1.0, 0.0, 0.0))
        for k, (p, c) in enumerate(((WORLD, "a"), ("a", "b"), (WORLD, "b")))
    )
    with pytest.raises(Unsupported, match="closing joint"):
        ADAPTER.build(Scene(bodies=(a, b), joints=slides), TUNED)
    rod = Distance(name="rod", parent=WORLD, child="b", anchor_W=NOWHERE, child_anchor_W=(1.0, 0.0, 0.0))
    with pytest.raises(Unsupported, match="rod"):
        ADAPTER.build(Scene(bodies=(a, b), joints=(rod,)), TUNED)


def test_a_pendulum_on_a_moving_cart_swings_as_one_on_the_world() -> None:
    cart = Body(name="cart", motion="kinematic", v_WB=(1.0, 0.0, 0.0))
    bob = Body(name="bob", inertia=principal_inertia(0.1, 0.1, 0.1), p_WB=(0.5, 0.0, 0.0))
    pin = Revolute(name="j", parent="cart", child="bob", anchor_W=NOWHERE, axis_W=(0.0, 1.0, 0.0))
    moving = Scene(bodies=(cart, replace(bob, v_WB=(1.0, 0.0, 0.0))), joints=(pin,))
    still = Scene(bodies=(bob,), joints=(replace(pin, parent=WORLD),))
    with built(moving, TUNED.with_dt(1e-3)) as one, built(still, TUNED.with_dt(1e-3)) as other:
        one.step(1000)
        other.step(1000)
        got, expected = state_of(one, moving), state_of(other, still)
    assert got.p_WB[1] - (1.0, 0.0, 0.0) == pytest.approx(expected.p_WB[0], abs=1e-9)
    assert got.p_WB[0] == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)
