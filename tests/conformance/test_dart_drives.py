"""Drives, springs and limits in DART: what is foreseen over a step, joint springs, servos."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import (
    WORLD,
    Body,
    Box,
    Drive,
    Joint,
    Limits,
    PlacedShape,
    Revolute,
    Scene,
    Spring,
    Vector3,
    box_inertia,
)
from plumbline.harness.trajectory import Floats, State

pytest.importorskip("dartpy", reason="DART is not installed")

from plumbline.adapters.dart import ADAPTER
from plumbline.adapters.dart.simulation import DartSimulation
from plumbline.adapters.dart.vendor import body_of
from plumbline.cases import stand_quadruped
from tests.conformance.dart_scenes import (
    DEFAULT,
    PD,
    TUNED,
    G,
    calls_of,
    free_body,
    ground_body,
    hinged_wheel,
    state_after,
    state_of,
    surface_law,
    with_options,
)

QUADRUPED = stand_quadruped.scene(stand_quadruped.P())


def _coordinate(scene: Scene, duration: float, settings: Settings | None = None) -> float:
    w, _, _, z = state_after(scene, duration, settings).q_WB[0]
    joint = scene.joints[0]
    assert isinstance(joint, Revolute)
    return float(2 * np.arctan2(z, w) + joint.position)


def test_a_limit_out_of_reach_leaves_the_drive_exactly_as_it_is_without_one() -> None:
    free, limited = (state_after(hinged_wheel(drive=drive), 1.0) for drive in (PD, replace(PD, limit=1e9)))
    np.testing.assert_allclose(limited.q_WB, free.q_WB, atol=1e-13)
    np.testing.assert_allclose(limited.w_WB, free.w_WB, atol=1e-13)


def test_a_saturated_drive_pushes_with_its_limit() -> None:
    # Full limit for 0.3 s: the wheel is still far from its target, w = f t/I.
    end = state_after(hinged_wheel(drive=replace(PD, stiffness=500.0, target=3.0, limit=2.0)), 0.3)
    assert abs(end.w_WB[0, 2] - 2.0 * 0.3 / 0.5) < 1e-9


def test_a_stiff_limited_drive_settles_at_a_coarse_step() -> None:
    drive = replace(PD, stiffness=1e6, damping=1e4, target_velocity=0.0, limit=20.0)
    # dt sqrt(k/I) is 6: explicit forces would explode, bang-bang ones would chatter by f dt^2/I = 7e-4.
    assert abs(_coordinate(hinged_wheel(drive=drive), 2.0, with_options(1 / 240)) - 1.2) < 1e-9


def test_a_limited_drive_tears_a_joint_loose_from_dry_friction_by_its_feedforward() -> None:
    scene = hinged_wheel(drive=Drive(feedforward=5.0, limit=10.0))
    stuck = replace(scene, joints=tuple(replace(joint, friction_loss=1.0) for joint in scene.joints))
    for settings in (DEFAULT, with_options(drives="stable")):
        # From rest by what friction leaves of it, w = f t/I.
        assert abs(state_after(stuck, 0.3, settings).w_WB[0, 2] - (5.0 - 1.0) * 0.3 / 0.5) < 1e-9


def test_a_command_moves_the_target_of_a_drive_and_names_a_joint_without_one() -> None:
    scene = hinged_wheel(drive=replace(PD, target_velocity=0.0))
    for limit in (None, 30.0):
        scene = hinged_wheel(drive=replace(PD, target_velocity=0.0, limit=limit))
        simulation = ADAPTER.build(scene, with_options())
        simulation.command({"hinge": -0.4})
        simulation.step(5000)
        w, _, _, z = state_of(simulation, scene).q_WB[0]
        # exp(-5 t) of the way is left after 5 s.
        assert abs(2 * np.arctan2(z, w) + 0.2 + 0.4) < 1e-6
    with pytest.raises(ValueError, match="hinge"):
        ADAPTER.build(hinged_wheel(spring=Spring(stiffness=1.0)), with_options()).command({"hinge": 0.0})


ARM_MASSES, ARM_LENGTHS, ARM_TARGETS = (3.0, 2.0, 1.0), (0.4, 0.35, 0.25), (0.5, -0.8, 0.6)
ARM_DRIVE = Drive(stiffness=200.0, damping=20.0)


def _arm() -> Scene:
    """Three links with shapes in a row along x, hinged about y, driven from rest at zero; a floor that they do not reach."""
    bodies: list[Body] = [ground_body(p=(0.0, 0.0, -1.0))]
    joints: list[Joint] = []
    x, parent = 0.0, WORLD
    for i, (mass, length, target) in enumerate(zip(ARM_MASSES, ARM_LENGTHS, ARM_TARGETS, strict=True)):
        half = (length / 2, 0.02, 0.02)
        name = f"link {i}"
        bodies.append(
            Body(
                name=name,
                mass=mass,
                inertia=box_inertia(mass, half),
                collision=(PlacedShape(shape=Box(half_extents=half)),),
                p_WB=(x + length / 2, 0.0, 0.0),
                material="b",
            )
        )
        joints.append(
            Revolute(
                name=name,
                parent=parent,
                child=name,
                anchor_W=(x, 0.0, 0.0),
                axis_W=(0.0, 1.0, 0.0),
                drive=replace(ARM_DRIVE, target=target),
            )
        )
        x, parent = x + length, name
    return Scene(bodies=tuple(bodies), joints=tuple(joints), surfaces=(surface_law(),), apart=(("b", "b"),))


@cache
def _lagrange(duration: float) -> tuple[Floats, float]:
    """Angles [rad] of the arm's links about y after `duration` [s], and the fastest turn [rad/s], from Lagrange's equations."""
    lengths, masses = np.array(ARM_LENGTHS), np.array(ARM_MASSES)
    central = np.array([box_inertia(m, (c / 2, 0.02, 0.02))[1][1] for m, c in zip(masses, lengths, strict=True)])
    # Centre of link i is the sum of its levers[i, j] along the directions (cos, -sin) of the links j.
    levers = np.tril(np.ones((3, 3)), -1) * lengths + np.diag(lengths / 2)

    def rate(_: float, y: Floats) -> Floats:
        turn, w = y[:3], y[3:]
        inertia, force = np.diag(central), np.zeros(3)
        for i in range(3):
            way = levers[i] * np.array([-np.sin(turn), -np.cos(turn)])
            inertia += masses[i] * way.T @ way
            inward = (levers[i] * w**2 * np.array([-np.cos(turn), np.sin(turn)])).sum(axis=1)
            force += masses[i] * way.T @ (np.array([0.0, -G]) - inward)
        bend, rate_of_bend = np.diff(turn, prepend=0.0), np.diff(w, prepend=0.0)
        torque = ARM_DRIVE.stiffness * (np.array(ARM_TARGETS) - bend) - ARM_DRIVE.damping * rate_of_bend
        return np.concatenate((w, np.linalg.solve(inertia, force + torque - np.append(torque[1:], 0.0))))

    solved = solve_ivp(rate, (0.0, duration), np.zeros(6), method="LSODA", rtol=1e-10, atol=1e-11)
    return solved.y[:3, -1], float(np.abs(solved.y[3:]).max())


@pytest.mark.parametrize("duration", [0.2, pytest.param(1.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("track", [TUNED, DEFAULT], ids=["tuned", "default"])
def test_a_driven_arm_beside_contact_converges_to_lagrange_s_equations(track: Settings, duration: float) -> None:
    """A step of first order is late by a step at most: the error is below dt times the fastest turn, and goes with dt."""
    expected, fastest = _lagrange(duration)
    errors, steps = [], (1 / 240, 1e-3, 2.5e-4)
    for dt in steps:
        q = state_after(_arm(), duration, with_options(dt, track)).q_WB[1:]
        errors.append(float(np.abs(2 * np.arctan2(q[:, 2], q[:, 0]) - expected).max()))
        assert errors[-1] < dt * fastest
    # The next order is dt times the rate at which the errors change, tens a second: a fifth at the coarse step.
    for k in (0, 1):
        assert errors[k] / errors[k + 1] == pytest.approx(steps[k] / steps[k + 1], rel=0.2)


def test_drives_are_foreseen_on_tuned_wherever_something_can_hold_them_and_joint_springs_elsewhere() -> None:
    standing, hung = QUADRUPED, hinged_wheel(drive=PD)
    stopped = hinged_wheel(drive=PD, limits=Limits(lower=-1.0))
    for scene, track, law in (
        (standing, TUNED, "stable"), (stopped, TUNED, "stable"), (hung, TUNED, "spring"), (standing, Settings(), "spring")
    ):  # fmt: skip
        assert ADAPTER.build(scene, with_options(1 / 240, track)).resolved.options["drives"] == law


@pytest.mark.parametrize("limit", [None, 20.0])
def test_a_drive_that_nothing_holds_obeys_the_same_law_foreseen_or_as_a_joint_spring(limit: float | None) -> None:
    scene = hinged_wheel(drive=replace(PD, limit=limit), spring=Spring(stiffness=3.0, damping=0.2, rest=-0.5))
    foreseen, sprung = (ADAPTER.build(scene, with_options(1 / 240, drives=law)) for law in ("stable", "spring"))
    for simulation in (foreseen, sprung):
        simulation.step(100)
        simulation.command({"hinge": 0.5})
        simulation.step(100)
    # The same equations solved in another order: rounding alone, over two hundred steps.
    np.testing.assert_allclose(state_of(foreseen, scene).q_WB, state_of(sprung, scene).q_WB, atol=1e-12)
    np.testing.assert_allclose(state_of(foreseen, scene).w_WB, state_of(sprung, scene).w_WB, atol=1e-12)


@pytest.mark.parametrize("limit", [None, 2e3])
def test_a_servo_closes_in_on_its_target_at_stiffness_over_damping_whatever_weighs_on_it(
    limit: float | None,
) -> None:
    """x' = k/c (t - x), implicit: a step leaves 1/(1 + dt k/c) of the way, a weight of 2 N m or none."""
    dt, steps = 1 / 240, 100
    scene = hinged_wheel(drive=replace(PD, target_velocity=0.0, limit=limit))
    for weight in (0.0, 2.0):
        simulation = ADAPTER.build(scene, with_options(dt, drives="servo"))
        assert simulation.resolved.options["drives"] == "servo"
        assert any("another law" in notice.text for notice in simulation.warnings())
        simulation.wrench(np.zeros((1, 3)), np.array([[0.0, 0.0, -weight]]))
        simulation.step(steps)
        w, _, _, z = state_of(simulation, scene).q_WB[0]
        left = PD.target - (0.2 + 2 * np.arctan2(z, w))
        # DART softens the constraint by 1e-9 of its mobility.
        assert abs(left - (PD.target - 0.2) / (1 + dt * PD.stiffness / PD.damping) ** steps) < 1e-7


def test_a_servo_pushes_with_no_more_than_its_limit() -> None:
    end = state_after(hinged_wheel(drive=replace(PD, target=3.0, limit=2.0)), 0.1, with_options(drives="servo"))
    # It would go at 28 rad/s: the limit bears all the while, w = f t/I.
    assert abs(end.w_WB[0, 2] - 2.0 * 0.1 / 0.5) < 1e-9


def test_a_quadruped_stands_on_servos_at_a_sixtieth_of_a_second_without_sagging() -> None:
    """It stands where its targets are: higher than on the scene's own drives, which give way under its weight."""
    machine = QUADRUPED
    servo = state_after(machine, 1.0, with_options(1 / 60, drives="servo")).p_WB[1, 2]
    finer = state_after(machine, 1.0, with_options(1 / 240, drives="servo")).p_WB[1, 2]
    assert servo > State.initial(machine).p_WB[1, 2]
    assert abs(servo - finer) < G / 60**2


def test_a_servo_is_refused_where_a_spring_would_press_beside_it_beyond_a_limit() -> None:
    scene = hinged_wheel(limits=Limits(upper=0.5), drive=PD, spring=Spring(stiffness=1.0, rest=2.0))
    with pytest.raises(Unsupported, match="servo"):
        ADAPTER.build(scene, with_options(drives="servo"))


def _on_springs(scene: Scene) -> Scene:
    """The same machine on passive springs and dampers."""
    joints = []
    for joint in scene.joints:
        assert isinstance(joint, Revolute)
        assert joint.drive is not None
        drive = joint.drive
        spring = Spring(stiffness=drive.stiffness, damping=drive.damping, rest=drive.target)
        joints.append(replace(joint, drive=None, spring=spring))
    return replace(scene, joints=tuple(joints))


@pytest.mark.parametrize(
    "machine",
    [QUADRUPED, _on_springs(QUADRUPED)],
    ids=["drives", "springs"],
)
def test_a_machine_in_equilibrium_stands_on_what_is_foreseen_and_sags_on_joint_springs(machine: Scene) -> None:
    """The deviation of joint springs: after a second the trunk has sunk by a centimetre at least. Foreseen, it falls for one
    step until its contacts are loaded, g dt^2, and stays: also at a step at which plain torques explode."""
    start = State.initial(machine)
    for dt in (1 / 60, 1 / 240):
        assert abs(state_after(machine, 1.0, with_options(dt)).p_WB[1, 2] - start.p_WB[1, 2]) < G * dt**2
    sagged = state_after(machine, 1.0, with_options(1 / 240, drives="spring"))
    assert start.p_WB[1, 2] - sagged.p_WB[1, 2] > 1e-2


def test_what_is_foreseen_of_machines_side_by_side_costs_what_it_costs_of_each() -> None:
    """In calls, which no load of the machine disturbs: few for one, and of four machines four times as many."""
    counts = []
    for n in (1, 4):
        simulation = ADAPTER.build(stand_quadruped.scene(stand_quadruped.P(n=n)), with_options(1 / 240, TUNED))
        simulation.step(20)
        counts.append(calls_of(partial(simulation.step, 10)) / 10)
    assert counts[0] < 400
    assert counts[1] < 4.2 * counts[0]


def test_what_is_foreseen_solves_the_law_with_all_that_holds() -> None:
    """Torques against the law with a multiplier for each hold, in plain words, of a quadruped whose contacts are loaded."""
    scene, dt = QUADRUPED, 1 / 240
    simulation = ADAPTER.build(scene, with_options(dt, TUNED))
    assert isinstance(simulation, DartSimulation)
    built = simulation._open
    [machine] = built.skeletons
    law = [(joint, joint.drive) for joint in scene.joints if isinstance(joint, Revolute) and joint.drive is not None]
    places = [built.coordinates[joint.name].getIndexInSkeleton(0) for joint, _ in law]
    k, c, target = (np.array([getattr(drive, name) for _, drive in law]) for name in ("stiffness", "damping", "target"))
    for _ in range(5):
        simulation.step(1)
        machine.computeForwardDynamics()
        u = machine.getVelocities() + dt * machine.getAccelerations()
        resisting, x = machine.getMassMatrix(), machine.getPositions()[places]
        rows = []
        for contact in built.world.getLastCollisionResult().getContacts():
            foot = built.nodes[body_of(contact.collisionObject1)]
            inside = foot.getWorldTransform().inverse()
            rows.append(machine.getWorldJacobian(foot, inside.rotation() @ contact.point + inside.translation())[3:])
        assert len(rows) == 4
        holds = np.vstack(rows)
        system = np.zeros((len(u) + 12, len(u) + 12))
        system[: len(u), : len(u)] = resisting
        system[places, places] += dt * (c + dt * k)
        system[len(u) :, : len(u)], system[: len(u), len(u) :] = holds, -holds.T
        right = np.concatenate((resisting @ u, np.zeros(12)))
        right[places] += dt * k * (target - x)
        end = np.linalg.solve(system, right)[places]
        assert simulation._foresight is not None
        simulation._foresight.foresee(begun=True)
        # What lets redundant holds share gives way by 1e-10 of the mobility.
        np.testing.assert_allclose(machine.getCommands()[places], k * (target - x - dt * end) - c * end, atol=1e-8)
        machine.resetCommands()


def _leaning_parallelogram() -> Scene:
    """Three bars of 1 kg and 1 m that lean by half a radian, held in equilibrium by a spring at one foot."""
    lean, stiffness = 0.5, 200.0
    x, z = float(np.sin(lean)), float(np.cos(lean))
    # About +y the weights turn both cranks further, by m g sin/2 each, and by m g sin for the coupler that they carry.
    held = Spring(stiffness=stiffness, damping=20.0, rest=-2 * G * x / stiffness)
    bars = (
        free_body("left", (x / 2, 0.0, z / 2)),
        free_body("top", (x + 0.5, 0.0, z)),
        free_body("right", (1 + x / 2, 0.0, z / 2)),
    )
    pins: tuple[tuple[str, str, Vector3], ...] = (
        (WORLD, "left", (0.0, 0.0, 0.0)),
        ("left", "top", (x, 0.0, z)),
        ("top", "right", (1 + x, 0.0, z)),
        (WORLD, "right", (1.0, 0.0, 0.0)),
    )
    joints = tuple(
        Revolute(
            name=f"{a}-{b}",
            parent=a,
            child=b,
            anchor_W=p,
            axis_W=(0.0, 1.0, 0.0),
            spring=held if (a, b) == pins[0][:2] else None,
        )
        for a, b, p in pins
    )
    return Scene(bodies=bars, joints=joints)


def test_a_loop_in_equilibrium_stands_on_a_spring_that_is_foreseen_and_sags_on_a_joint_spring() -> None:
    scene = _leaning_parallelogram()
    start = State.initial(scene).p_WB[1, 2]
    foreseen, sprung = (
        state_after(scene, 1.0, settings).p_WB[1, 2] for settings in (with_options(1 / 240), with_options(1 / 240, DEFAULT))
    )
    # Statics: rounding, and what makes redundant holds share; the joint spring gives way while the loop is being closed.
    assert abs(foreseen - start) < 1e-9
    assert start - sprung > 1e-4


def test_a_spring_whose_rest_lies_beyond_a_limit_presses_against_it_with_its_full_force() -> None:
    """DART refuses such a rest position on the console only; a push against the motion shows what is left."""
    limited = hinged_wheel(limits=Limits(lower=-0.3, upper=0.5), spring=Spring(stiffness=20.0, damping=2.0, rest=2.0))
    assert abs(_coordinate(limited, 2.0) - 0.5) < 1e-6
    # Before it reaches the limit it moves as it would without: a from rest is k (rest - x)/I.
    free = hinged_wheel(spring=Spring(stiffness=20.0, damping=2.0, rest=2.0))
    assert abs(_coordinate(limited, 0.05) - _coordinate(free, 0.05)) < 1e-12
    assert _coordinate(free, 0.05) > 0.25


def test_a_joint_hung_by_its_parent_counts_its_coordinate_the_same_way() -> None:
    """The wheel as the parent of the world's stand-in: a positive push turns the parent backwards."""
    post = Body(name="post", motion="static")
    joint = Revolute(
        name="j", parent="wheel", child="post", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 0.0, 1.0), position=0.2, drive=PD
    )
    backwards = Scene(bodies=(free_body("wheel", moment=0.5), post), joints=(joint,), gravity=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(
        state_after(backwards, 0.5).w_WB[0], -state_after(hinged_wheel(drive=PD), 0.5).w_WB[0], atol=1e-12
    )
