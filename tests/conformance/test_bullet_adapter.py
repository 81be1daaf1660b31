"""What is particular to Bullet: its two kinds of coordinates, product rules, turned inertia, multibodies and second world."""

import math
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from adapters.bullet import ADAPTER
from harness.adapter import Diverged, Settings, SettingsError, Simulation, Unsupported
from harness.conformance.exact import rotation, turning
from harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    Camera,
    ConvexHull,
    Cylinder,
    Distance,
    Drive,
    Effect,
    Fixed,
    Joint,
    Limits,
    PlacedShape,
    Plane,
    Prismatic,
    Revolute,
    Scene,
    Shape,
    Sphere,
    Spring,
    Surface,
    TriangleMesh,
    axis_angle,
    box_inertia,
    multiply,
    principal_inertia,
    sphere_inertia,
)
from harness.trajectory import State

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

G = 9.81
NOWHERE = (0.0, 0.0, 0.0)
TURNED = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
DEFAULT, TUNED = ADAPTER.tracks["default"], ADAPTER.tracks["tuned"]


def with_options(settings: Settings, **options: Any) -> Settings:
    return replace(settings, options={**settings.options, **options})


MULTIBODY, MAXIMAL = with_options(TUNED, coordinates="multibody"), with_options(TUNED, coordinates="maximal")
COORDINATES = pytest.mark.parametrize("settings", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])


@contextmanager
def built(scene: Scene, settings: Settings) -> Iterator[Simulation]:
    simulation = ADAPTER.build(scene, settings)
    try:
        yield simulation
    finally:
        simulation.close()


def state_of(simulation: Simulation, scene: Scene) -> State:
    state = State.empty(len(scene.bodies))
    simulation.state(state)
    return state


def vector(numbers: Any) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in numbers)
    return (x, y, z)


def tensor(*moments: float) -> Any:
    """A tensor with these principal moments about axes that no axis of B lies along: all products count."""
    R = rotation(axis_angle((3.0, 1.0, 2.0), 0.8))
    return tuple(map(tuple, (R @ np.diag(moments) @ R.T).tolist()))


def solid(shape: Shape, name: str = "body", mass: float = 2.0, **more: Any) -> Body:
    inertia = more.pop("inertia", box_inertia(mass, (0.2, 0.15, 0.1)))
    return Body(name=name, mass=mass, inertia=inertia, material="solid", collision=(PlacedShape(shape=shape),), **more)


def ball(radius: float = 0.1, **more: Any) -> Body:
    return solid(Sphere(radius=radius), mass=1.0, inertia=sphere_inertia(1.0, radius), **more)


GROUND = Body(
    name="ground",
    motion="static",
    material="ground",
    p_WB=(0.0, 0.0, -0.5),
    collision=(PlacedShape(shape=Box(half_extents=(20.0, 20.0, 0.5))),),
)


def law(friction: float = 0.0, restitution: float = 0.0, pair: tuple[str, str] = ("ground", "solid"), **more: float) -> Surface:
    return Surface(between=pair, static_friction=friction, kinetic_friction=friction, restitution=restitution, **more)


@COORDINATES
def test_a_body_with_products_of_inertia_turns_as_euler_says(settings: Settings) -> None:
    w, t, dt = (3.0, 1.0, -2.0), 0.5, 1e-4
    body = Body(name="top", inertia=tensor(0.3, 0.5, 0.6), q_WB=TURNED, w_WB=w)
    scene = Scene(bodies=(body,), gravity=NOWHERE)
    with built(scene, settings.with_dt(dt)) as simulation:
        simulation.step(round(t / dt))
        got = state_of(simulation, scene)
    q, expected = turning(body.inertia, TURNED, w, t)
    # A first-order scheme errs by about |w'| w dt t ~ 20 * dt; a tensor in the wrong frame by the change itself, above 1.
    assert np.abs(got.w_WB[0] - expected).max() < 20 * dt
    assert min(np.abs(got.q_WB[0] - q).max(), np.abs(got.q_WB[0] + q).max()) < 20 * dt


@COORDINATES
def test_the_first_step_has_the_inertia_that_the_scene_gives(settings: Settings) -> None:
    """In maximal coordinates Bullet renews the inertia in W at the end of a step only."""
    tau, dt = np.array([0.3, -0.2, 0.5]), 1e-3
    body = Body(name="body", inertia=tensor(0.3, 0.5, 0.6), q_WB=TURNED)
    scene = Scene(bodies=(body,), gravity=NOWHERE)
    with built(scene, settings.with_dt(dt)) as simulation:
        simulation.wrench(np.zeros((1, 3)), tau[None])
        simulation.step()
        got = state_of(simulation, scene).w_WB[0]
    R = rotation(TURNED)
    # From rest, one step gives exactly I^-1 tau dt; rounding alone lies between.
    assert got == pytest.approx(R @ np.linalg.solve(np.asarray(body.inertia), R.T @ tau) * dt, abs=1e-12)


@COORDINATES
def test_free_fall_errs_by_exactly_half_a_step(settings: Settings) -> None:
    scene = Scene(bodies=(Body(name="body", inertia=tensor(0.3, 0.5, 0.6), q_WB=TURNED, v_WB=(1.0, 0.0, 2.0)),))
    with built(scene, settings.with_dt(1 / 240)) as simulation:
        simulation.step(240)
        got = state_of(simulation, scene)
    assert got.p_WB[0] == pytest.approx((1.0, 0.0, 2.0 - G / 2 - G / 480), abs=1e-11)
    assert got.v_WB[0] == pytest.approx((1.0, 0.0, 2.0 - G), abs=1e-11)


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


@COORDINATES
def test_contact_forces_of_a_resting_box_carry_its_weight_from_A_to_B(settings: Settings) -> None:
    box = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.1))
    for bodies, sign in (((GROUND, box), 1.0), ((box, GROUND), -1.0)):
        with built(Scene(bodies=bodies, surfaces=(law(0.5),)), settings) as simulation:
            simulation.step(240)
            contacts = simulation.contacts()
        assert len(contacts) == 4
        assert (contacts.body_A == 0).all()
        assert contacts.normal_W[:, 2] == pytest.approx(np.full(4, sign), abs=1e-9)
        # Bullet lets contacts sink in by its slop of 1e-5 m.
        assert contacts.gap == pytest.approx(np.full(4, -1e-5), abs=2e-6)
        # After one second the solver's residual alone is left.
        assert contacts.force_W.sum(axis=0) == pytest.approx((0.0, 0.0, sign * 2.0 * G), abs=1e-4)


BARE = with_options(DEFAULT, damping="scene")
"""The default track without the vendor's damping, which is no contact force."""


@pytest.mark.parametrize("settings", [BARE, MULTIBODY, MAXIMAL], ids=["default", "multibody", "maximal"])
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
@pytest.mark.parametrize("shape", ["ball", "tumbling box"])
def test_contact_forces_are_those_of_the_step_whose_momentum_they_change(shape: str, dt: float, settings: Settings) -> None:
    """Through flights, blows and rebounds: m dv = (f + m g) dt in every step, so that no force outlives its step."""
    body = solid(Sphere(radius=0.1), p_WB=(0.0, 0.0, 0.6), inertia=sphere_inertia(2.0, 0.1))
    if shape == "tumbling box":
        body = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.6), w_WB=(4.0, 3.0, 1.0), v_WB=(1.0, 0.0, 0.0))
    scene = Scene(bodies=(GROUND, body), surfaces=(law(0.5, restitution=0.5),))
    with built(scene, settings.with_dt(dt)) as simulation:
        before = state_of(simulation, scene).v_WB[1]
        for _ in range(round(1.0 / dt)):
            simulation.step()
            after = state_of(simulation, scene).v_WB[1]
            force = simulation.contacts().force_W.sum(axis=0)
            # Momentum is summed in double precision: forces of 1e4 N round at 1e-12, the change of velocity over dt at 1e-11.
            assert force == pytest.approx(2.0 * (after - before) / dt + (0.0, 0.0, 2.0 * G), abs=1e-6)
            before = after


@COORDINATES
def test_friction_forces_brake_the_sliding_body(settings: Settings) -> None:
    box = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.1), v_WB=(2.0, 0.0, 0.0))
    with built(Scene(bodies=(GROUND, box), surfaces=(law(0.4),)), settings.with_dt(1e-3)) as simulation:
        simulation.step(50)
        force = simulation.contacts().force_W.sum(axis=0)
    # On B, the box: against its motion with mu times its weight; 1 % for the wobble of a sliding manifold.
    assert force[0] == pytest.approx(-0.4 * 2.0 * G, rel=0.01)
    assert force[2] == pytest.approx(2.0 * G, rel=0.01)


def test_sliding_in_maximal_coordinates_stops_at_the_same_distance_in_all_directions() -> None:
    for azimuth in (0.0, math.pi / 8, math.pi / 4, math.pi / 2):
        v = (2 * math.cos(azimuth), 2 * math.sin(azimuth), 0.0)
        box = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 0.1), v_WB=v)
        scene = Scene(bodies=(GROUND, box), surfaces=(law(0.4),))
        with built(scene, TUNED.with_dt(1e-3)) as simulation:
            simulation.step(1000)
            way = math.hypot(*state_of(simulation, scene).p_WB[1, :2])
        # d = v^2/(2 mu g) less v dt/2 (0.2 %); a box instead of a cone would be 29 % off at 45 degrees.
        assert way == pytest.approx(4 / (2 * 0.4 * G), rel=0.005)


@pytest.mark.parametrize("e", [0.5, 0.8])
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
def test_tuned_rebounds_do_not_depend_on_the_phase_of_the_step(e: float, dt: float) -> None:
    for height in np.linspace(0.9, 1.1, 7):
        scene = Scene(bodies=(GROUND, ball(p_WB=(0.0, 0.0, 0.1 + height))), surfaces=(law(restitution=e),))
        with built(scene, TUNED.with_dt(dt)) as simulation:
            speeds = [0.0]
            while speeds[-1] <= 0.0:
                simulation.step()
                speeds.append(state_of(simulation, scene).v_WB[1, 2])
        # The impact speed is the last speed before: the product e v is formed of the velocity before that step's gravity.
        assert speeds[-1] / -speeds[-2] == pytest.approx(e, abs=1e-6)


@pytest.mark.parametrize("dt", [1 / 240, 1e-3, 2e-5])
@pytest.mark.parametrize("e", [0.5, 1.0])
@pytest.mark.parametrize("shape", [Sphere(radius=0.1), Box(half_extents=(0.1, 0.1, 0.1))], ids=["ball", "box"])
def test_tuned_rebounds_do_not_depend_on_the_time_step(shape: Shape, e: float, dt: float) -> None:
    for phase in (0.1, 0.5, 0.9, 0.999):
        body = solid(shape, p_WB=(0.0, 0.0, 0.1 + (20 + phase) * dt), v_WB=(0.0, 0.0, -1.0))
        scene = Scene(bodies=(GROUND, body), surfaces=(law(restitution=e),), gravity=NOWHERE)
        with built(scene, TUNED.with_dt(dt)) as simulation:
            simulation.step(40)
            # The contact slop takes at most 1e-6 m/s, at any step.
            assert state_of(simulation, scene).v_WB[1, 2] == pytest.approx(e, abs=1.1e-6)


def leaning(slope: float) -> tuple[float, float, float]:
    """Gravity as on a slope [rad] towards +x."""
    return (G * math.sin(slope), 0.0, -G * math.cos(slope))


PLANE = replace(GROUND, p_WB=NOWHERE, collision=(PlacedShape(shape=Plane()),))
CUBE, CYLINDER = Box(half_extents=(0.1, 0.1, 0.1)), Cylinder(radius=0.1, half_length=0.1)
HULL = ConvexHull(vertices=tuple((x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)))


@pytest.mark.parametrize("ground", [GROUND, PLANE], ids=["on a box", "on a plane"])
@pytest.mark.parametrize("shape", [CUBE, CYLINDER, HULL], ids=["cube", "cylinder", "hull"])
@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside a bouncing ball"])
def test_what_slides_down_a_slope_on_tuned_goes_its_way(beside: bool, shape: Shape, ground: Body) -> None:
    slope = math.atan(0.55)
    body = solid(shape, p_WB=(0.0, 0.0, 0.1), inertia=box_inertia(2.0, (0.1, 0.1, 0.1)))
    bodies, surfaces = (ground, body), (law(0.5),)
    if beside:
        bouncing = replace(ball(name="ball", p_WB=(0.0, 5.0, 0.4)), material="rubber")
        pairs = {("ground", "rubber"): 0.5, ("rubber", "solid"): 0.0}
        bodies += (bouncing,)
        surfaces += tuple(law(0.5, restitution=e, pair=pair) for pair, e in pairs.items())
    scene = Scene(bodies=bodies, surfaces=surfaces, gravity=leaning(slope))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(1000)
        way = state_of(simulation, scene).p_WB[1, 0]
    # Bullet's multibodies go 1.00-1.03 of the way; friction that is 1 % off shows as 10 % here, and maximal coordinates go
    # 0.85-0.88 on the plane and with the cylinder.
    assert way == pytest.approx(G / 2 * (math.sin(slope) - 0.5 * math.cos(slope)), rel=0.03)


@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
@pytest.mark.parametrize("ground", [GROUND, PLANE], ids=["on a box", "on a plane"])
@pytest.mark.parametrize("shape", [CUBE, CYLINDER], ids=["cube", "cylinder"])
def test_what_friction_holds_creeps_less_than_bullets_own_residue(shape: Shape, ground: Body, dt: float) -> None:
    body = solid(shape, p_WB=(0.0, 0.0, 0.1), inertia=box_inertia(2.0, (0.1, 0.1, 0.1)))
    scene = Scene(bodies=(ground, body), surfaces=(law(0.5),))
    push = np.zeros((2, 3))
    push[1, 0] = 0.9 * 0.5 * 2.0 * G
    with built(scene, TUNED.with_dt(dt)) as simulation:
        simulation.wrench(push, np.zeros((2, 3)))
        simulation.step(round(1.5 / dt))
        # Contact slop and processing threshold both 0, right for rebounds, would let it creep 3-6 mm; a tenth of that is more
        # than twice what Bullet cannot help while its contact points gather, 0.02-0.22 mm.
        assert state_of(simulation, scene).p_WB[1, 0] < 0.55e-3


def test_a_body_that_turns_fast_beside_a_slope_does_not_explode_on_tuned() -> None:
    w = (100.0, 100.0, 100.0)
    top = solid(Box(half_extents=(0.2, 0.15, 0.1)), p_WB=(0.0, 0.0, 50.0), w_WB=w, inertia=principal_inertia(0.01, 0.02, 0.025))
    scene = Scene(bodies=(PLANE, top), surfaces=(law(0.5),), gravity=(1e-3, 0.0, -1e-3))
    with built(scene, TUNED) as simulation:
        simulation.step(480)
        # An implicit gyroscopic term takes energy at such a step and gives none; an explicit one gives 1e9 times as much.
        assert np.linalg.norm(state_of(simulation, scene).w_WB[1]) < np.linalg.norm(w)


def test_products_of_numbers_give_each_pair_its_value_or_the_pair_is_named() -> None:
    boxes = (solid(Box(half_extents=(0.2, 0.2, 0.05)), p_WB=(0.0, 0.0, 0.05)), ball(name="ball", p_WB=(0.0, 0.0, 0.2)))
    a, b = boxes[0], replace(boxes[1], material="rubber")
    pairs = {("ground", "solid"): 0.3, ("ground", "rubber"): 0.9, ("rubber", "solid"): 0.6}
    scene = Scene(bodies=(GROUND, a, b), surfaces=tuple(law(mu, pair=pair) for pair, mu in pairs.items()))
    # Three unknowns, three pairs: solvable. A fourth pair of no friction asks for a zero where none may be.
    ADAPTER.build(scene, TUNED).close()
    twin = replace(a, name="twin", p_WB=(3.0, 0.0, 0.05))
    with pytest.raises(Unsupported, match=r"surface .* multiplies the friction"):
        ADAPTER.build(Scene(bodies=(*scene.bodies, twin), surfaces=(*scene.surfaces, law(0.0, pair=("solid", "solid")))), TUNED)
    sticky = Surface(between=("ground", "solid"), static_friction=0.6, kinetic_friction=0.4)
    with pytest.raises(Unsupported, match="static and kinetic"):
        ADAPTER.build(Scene(bodies=(GROUND, a), surfaces=(sticky,)), TUNED)
    with pytest.raises(Unsupported, match="clamps friction"):
        ADAPTER.build(Scene(bodies=(GROUND, a), surfaces=(law(20.0),)), TUNED)


def test_friction_that_no_product_gives_is_refused_with_the_pair() -> None:
    """Six pairs of four materials for four numbers: mu of ground and a, b, c is x_g x_i, so mu_ab mu_gc = mu_ac mu_gb."""
    names = ("a", "b", "c")
    balls = tuple(replace(ball(name=n, p_WB=(0.5 * k, 0.0, 0.1)), material=n) for k, n in enumerate(names))
    pairs = dict.fromkeys([("ground", n) for n in names], 0.5) | {("a", "b"): 0.4, ("a", "c"): 0.4, ("b", "c"): 0.4}

    def scene(**changed: float) -> Scene:
        told = pairs | {(k[0], k[1]): mu for k, mu in changed.items()}
        return Scene(bodies=(GROUND, *balls), surfaces=tuple(law(mu, pair=pair) for pair, mu in told.items()))

    ADAPTER.build(scene(), TUNED).close()
    with pytest.raises(Unsupported, match=r"surface .*: Bullet multiplies the friction of the two bodies; no numbers give"):
        ADAPTER.build(scene(ab=0.8), TUNED)


def test_rolling_and_torsional_friction_are_lengths() -> None:
    rolling = ball(p_WB=(0.0, 0.0, 0.1), v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 10.0, 0.0))
    scene = Scene(bodies=(GROUND, rolling), surfaces=(law(0.5, rolling_friction=0.005),))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(500)
        # b N = torque: v' = -(5/7) b g / r.
        assert state_of(simulation, scene).v_WB[1, 0] == pytest.approx(1 - 0.5 * 5 / 7 * 0.005 * G / 0.1, abs=1e-4)
    spinning = ball(p_WB=(0.0, 0.0, 0.1), w_WB=(0.0, 0.0, 10.0))
    scene = Scene(bodies=(GROUND, spinning), surfaces=(law(0.5, torsional_friction=0.002),))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(100)
        assert state_of(simulation, scene).w_WB[1, 2] == pytest.approx(10 - 0.1 * 0.002 * G / 0.004, abs=1e-3)


@pytest.mark.parametrize("mu", [0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
def test_torsional_and_rolling_friction_act_whichever_body_of_the_pair_bears_the_lever(mu: float) -> None:
    """The lever of a pair is shared out between two numbers, and rounding may give all of it to the ground."""
    spinning = ball(p_WB=(0.0, 0.0, 0.1), w_WB=(0.0, 0.0, 20.0))
    with built(Scene(bodies=(GROUND, spinning), surfaces=(law(mu, torsional_friction=0.002),)), TUNED.with_dt(1e-3)) as run:
        run.step(100)
        # w' = -b g/(2/5 r^2); contact is solved in each of the 100 steps.
        assert state_of(run, Scene(bodies=(GROUND, spinning), surfaces=(law(mu),))).w_WB[1, 2] == pytest.approx(
            20 - 0.1 * 0.002 * G / 0.004, abs=1e-3
        )
    rolling = ball(p_WB=(0.0, 0.0, 0.1), v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 10.0, 0.0))
    with built(Scene(bodies=(GROUND, rolling), surfaces=(law(mu, rolling_friction=0.002),)), TUNED.with_dt(1e-3)) as run:
        run.step(100)
        assert state_of(run, Scene(bodies=(GROUND, rolling), surfaces=(law(mu),))).v_WB[1, 0] == pytest.approx(
            1 - 0.1 * 5 / 7 * 0.002 * G / 0.1, abs=1e-4
        )


@pytest.mark.parametrize("mu", [0.3, 0.4, 0.5, 0.6, 0.8, 1.0])
def test_effects_that_bullet_has_in_other_coordinates_only_are_refused_together(mu: float) -> None:
    damped = ball(p_WB=(0.0, 0.0, 0.1), linear_damping=0.1)
    scene = Scene(bodies=(GROUND, damped), surfaces=(law(mu, rolling_friction=0.005),))
    with pytest.raises(Unsupported, match="damping with rolling"):
        ADAPTER.build(scene, TUNED)
    swinging = Body(name="bob", p_WB=(1.0, 0.0, 0.0), angular_damping=0.1)
    with pytest.raises(Unsupported, match="damping of body 'bob'"):
        ADAPTER.build(Scene(bodies=(swinging,), joints=(Ball(name="j", parent=WORLD, child="bob", anchor_W=NOWHERE),)), TUNED)


@pytest.mark.parametrize("track", ["default", "tuned"])
def test_damping_is_exponential_whatever_the_step(track: str) -> None:
    body = Body(name="body", linear_damping=2.0, angular_damping=3.0, v_WB=(3.0, 0.0, 0.0), w_WB=(0.0, 0.0, 3.0))
    scene = Scene(bodies=(body,), gravity=NOWHERE)
    with built(scene, ADAPTER.tracks[track].with_dt(0.05)) as simulation:
        simulation.step(10)
        got = state_of(simulation, scene)
    assert got.v_WB[0, 0] == pytest.approx(3 * math.exp(-1.0), rel=1e-12)
    assert got.w_WB[0, 2] == pytest.approx(3 * math.exp(-1.5), rel=1e-12)


@COORDINATES
def test_fast_bodies_stay_fast_on_tuned(settings: Settings) -> None:
    scene = Scene(bodies=(Body(name="body", v_WB=(200.0, 0.0, 0.0), w_WB=(0.0, 0.0, 500.0)),), gravity=NOWHERE)
    with built(scene, settings) as simulation:
        simulation.step(240)
        got = state_of(simulation, scene)
    assert got.v_WB[0, 0] == pytest.approx(200.0, rel=1e-9)
    assert got.p_WB[0, 0] == pytest.approx(200.0, rel=1e-9)
    assert got.w_WB[0, 2] == pytest.approx(500.0, rel=1e-9)


@pytest.mark.parametrize("speed", [10.0, 500.0])
def test_continuous_collision_stops_a_ball_at_a_thin_wall_in_every_phase(speed: float) -> None:
    wall = replace(GROUND, p_WB=NOWHERE, collision=(PlacedShape(shape=Box(half_extents=(0.005, 1.0, 1.0))),))
    for phase in np.linspace(0.0, 1.0, 8, endpoint=False):
        bullet = ball(0.05, p_WB=(-1.0 - phase * speed / 240, 0.0, 0.0), v_WB=(speed, 0.0, 0.0))
        scene = Scene(bodies=(bullet, wall), surfaces=(law(),), gravity=NOWHERE, widen=Effect.CONTINUOUS_COLLISION)
        with built(scene, TUNED) as simulation:
            simulation.step(60 + int(480 / speed))
            assert state_of(simulation, scene).p_WB[0, 0] < -0.02


def test_a_ball_on_a_turntable_circles_at_two_sevenths_of_its_rate() -> None:
    rate, r, x, t = 2.0, 0.1, 1.0, 2.0
    own = 2 / 7 * rate
    table = replace(GROUND, motion="kinematic", w_WB=(0.0, 0.0, rate))
    rolling = ball(r, p_WB=(x, 0.0, r), v_WB=(0.0, own * x, 0.0), w_WB=((rate - own) * x / r, 0.0, 0.0))
    scene = Scene(bodies=(table, rolling), surfaces=(law(0.8),))
    with built(scene, TUNED.with_dt(1e-3)) as simulation:
        simulation.step(round(t / 1e-3))
        got = state_of(simulation, scene)
    assert math.atan2(got.p_WB[1, 1], got.p_WB[1, 0]) == pytest.approx(own * t, abs=1e-3)
    assert math.hypot(*got.p_WB[1, :2]) == pytest.approx(x, abs=2e-3)
    # Whatever rolls on it, the table keeps its motion; 1e-12 is the ratio of masses.
    assert got.w_WB[0] == pytest.approx((0.0, 0.0, rate), abs=1e-10)
    assert got.p_WB[0] == pytest.approx((0.0, 0.0, -0.5), abs=1e-10)


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


@pytest.mark.parametrize("static", [True, False], ids=["on a mesh", "as a hull"])
def test_hulls_and_meshes_have_no_margin_on_tuned(static: bool) -> None:
    corners = tuple((x, y, z) for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.1, 0.1))
    square = ((-5.0, -5.0, 0.0), (5.0, -5.0, 0.0), (5.0, 5.0, 0.0), (-5.0, 5.0, 0.0))
    mesh = PlacedShape(shape=TriangleMesh(vertices=square, faces=((0, 1, 2), (0, 2, 3))))
    ground = replace(GROUND, p_WB=NOWHERE, collision=(mesh,)) if static else GROUND
    body = solid(Box(half_extents=(0.2, 0.15, 0.1)) if static else ConvexHull(vertices=corners), p_WB=(0.3, 0.0, 0.1))
    scene = Scene(bodies=(ground, body), surfaces=(law(0.5),))
    with built(scene, TUNED) as simulation:
        simulation.step(480)
        height = state_of(simulation, scene).p_WB[1, 2]
    # The slop of 1e-5 m is left; the vendor's margin is 1e-3 m.
    assert height == pytest.approx(0.1, abs=5e-5)


def test_a_moving_triangle_mesh_is_refused() -> None:
    mesh = TriangleMesh(
        vertices=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)), faces=((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    )
    with pytest.raises(Unsupported, match="convex"):
        ADAPTER.build(Scene(bodies=(Body(name="body", collision=(PlacedShape(shape=mesh),)),)), TUNED)


def test_more_rays_than_one_call_takes_all_come_back() -> None:
    scene = Scene(bodies=(GROUND,))
    n = 40_000
    origins = np.column_stack((np.linspace(-10, 10, n), np.zeros(n), np.linspace(1, 3, n)))
    with built(scene, TUNED) as simulation:
        hits = simulation.cast(origins, np.tile((0.0, 0.0, -1.0), (n, 1)), 10.0)
    assert hits.distance == pytest.approx(origins[:, 2], abs=1e-9)
    assert (hits.body == 0).all()


def test_rays_see_bodies_where_they_are_even_in_a_scene_without_contact() -> None:
    scene = Scene(bodies=(ball(p_WB=(0.0, 0.0, 5.0), v_WB=(4.0, 0.0, 0.0)),), gravity=NOWHERE)
    assert Effect.CONTACT not in scene.effects
    with built(scene, TUNED) as simulation:
        simulation.step(60)
        hits = simulation.cast(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.tile((0.0, 0.0, 1.0), (2, 1)), 10.0)
    assert hits.distance[0] == np.inf
    # Through the centre Bullet's ray test is good to its tolerance of 1e-4 of the radius.
    assert hits.distance[1] == pytest.approx(4.9, abs=1e-4)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)])
def test_depth_of_a_plane_is_right_at_the_centres_of_the_pixels(axis: tuple[float, float, float]) -> None:
    plane = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    camera = Camera(
        name="eye",
        body=WORLD,
        rate=1.0,
        p_BS=(0.0, 0.0, 3.0),
        q_BS=multiply((0.0, 1.0, 0.0, 0.0), axis_angle(axis, 0.9)),
        width=64,
        height=48,
        focal_x=50.0,
        focal_y=60.0,
        centre_x=30.0,
        centre_y=20.0,
    )
    with built(Scene(bodies=(plane,)), TUNED) as simulation:
        depth = simulation.render(camera).depth
    u, v = np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5)
    rays = np.stack([(u - 30) / 50, (v - 20) / 60, np.ones_like(u)], axis=-1) @ rotation(camera.q_BS).T
    with np.errstate(divide="ignore"):
        expected = np.where(rays[..., 2] < 0, -3 / rays[..., 2], np.inf)
    near = expected < 20
    # The buffer is single precision: dz = z^2/near * 6e-8 = 5e-4 m at 20 m; half a pixel would be 1 %.
    assert np.abs(depth - expected)[near].max() < 1e-3


def test_a_state_that_is_no_number_is_never_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    """The door lets no such number in; Bullet makes one from a NaN that is let past it, and says nothing."""
    monkeypatch.setattr("adapters.bullet.simulation.check_wrench", lambda *_: None)
    for joints in ((), (Ball(name="j", parent=WORLD, child="body", anchor_W=NOWHERE),)):
        scene = Scene(bodies=(Body(name="body", p_WB=(1.0, 0.0, 0.0)),), joints=joints)
        with built(scene, TUNED) as simulation:
            simulation.wrench(np.full((1, 3), np.nan), np.zeros((1, 3)))
            with pytest.raises(Diverged):
                simulation.step(3)


def test_options_are_checked_and_resolved_settings_are_complete() -> None:
    scene = Scene(bodies=(Body(name="body"),))
    for options in ({"coordinates": "polar"}, {"erp": -1.0}, {"erp": "high"}, {"split_impulse": 1.0}, {"velocity_limit": True}):
        with pytest.raises(SettingsError, match=next(iter(options))):
            ADAPTER.build(scene, with_options(TUNED, **options))
    with built(scene, replace(DEFAULT, substeps=4, dt=0.01)) as simulation:
        resolved = simulation.resolved
    assert resolved.dt == pytest.approx(0.01, rel=1e-12)
    assert (resolved.substeps, resolved.iterations) == (4, 50)
    assert resolved.options["restitution_threshold"] == 0.2


def test_what_the_vendor_adds_by_default_is_said() -> None:
    scene = Scene(bodies=(Body(name="body"),))
    with built(scene, DEFAULT) as default, built(scene, TUNED) as tuned:
        assert Effect.LINEAR_DAMPING in {notice.effect for notice in default.warnings() if notice.kind == "surplus"}
        assert tuned.warnings() == ()


def test_nothing_of_bullet_reaches_the_standard_streams() -> None:
    program = (
        "from adapters.bullet import ADAPTER; from harness.scene import Body, Scene;"
        "s = ADAPTER.build(Scene(bodies=(Body(name='a'),)), ADAPTER.tracks['tuned']); s.step(); s.close()"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert (run.stdout, run.stderr) == (b"", b"")
