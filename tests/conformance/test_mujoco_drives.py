"""Which of MuJoCo's integrators a scene with springs and dampers takes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from plumbline.harness.adapter import Diverged, Unsupported
from plumbline.harness.scene import (
    WORLD,
    Body,
    Box,
    Drive,
    Prismatic,
    Revolute,
    Scene,
    Spring,
    principal_inertia,
)
from plumbline.harness.trajectory import Floats
from tests.conformance.mujoco_scenes import DEFAULT, TUNED, G, built, hinge_at, on_ground, shaped_body, stack, state_of


def test_by_scene_the_integrator_follows_contacts_and_stiffness() -> None:
    body = Body(name="b", inertia=principal_inertia(0.1, 0.1, 0.1))
    # sqrt(k/I) dt is 1.0 and 3.2; RK4 is stable up to 2.8.
    firm, stiff = (
        Scene(bodies=(body,), joints=(hinge_at("j", WORLD, "b", (0, 0, 0), drive=Drive(stiffness=k)),)) for k in (1e5, 1e6)
    )
    box = shaped_body("b", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1))
    for e, name in ((0.0, "discrete"), (0.5, "implicitfast")):
        assert built(replace(on_ground(box, e=e), joints=stiff.joints), TUNED).resolved.integrator == name
    assert built(Scene(bodies=(body,)), TUNED).resolved.integrator == "rk4"
    assert built(stack(1), TUNED).resolved.integrator == "euler"
    assert built(firm, TUNED).resolved.integrator == "rk4"
    assert built(stiff, TUNED).resolved.integrator == "discrete"
    assert built(stiff, DEFAULT).resolved.integrator == "euler"
    with pytest.raises(Unsupported, match="discrete integrator"):
        built(on_ground(box, e=0.5), replace(TUNED, integrator="discrete"))


def test_where_nothing_is_moved_by_a_force_one_stage_does() -> None:
    fixed = shaped_body("wall", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.0))
    for motion, integrator in (("static", "euler"), ("kinematic", "euler"), ("dynamic", "rk4")):
        scene = Scene(bodies=(replace(fixed, motion=motion),))
        assert built(scene, TUNED).resolved.integrator == integrator


ARM_LENGTHS, ARM_MASSES, ARM_TARGETS = np.array([0.4, 0.35, 0.25]), np.array([3.0, 2.0, 1.0]), np.array([0.5, -0.8, 0.6])


def _arm(stiffness: float, damping: float) -> Scene:
    """Three rods in a row along x, held out over the ground by drives of their hinges; angles count from x upwards."""
    bodies, joints, x = [], [], 0.0
    for k, (length, mass, target) in enumerate(zip(ARM_LENGTHS, ARM_MASSES, ARM_TARGETS, strict=True)):
        turning = mass * length**2 / 12
        bodies.append(
            Body(name=f"l{k}", mass=mass, inertia=principal_inertia(1e-3, turning, turning), p_WB=(x + length / 2, 0.0, 0.0))
        )
        drive = Drive(stiffness=stiffness, damping=damping, target=target)
        parent = WORLD if k == 0 else f"l{k - 1}"
        joints.append(
            Revolute(name=f"j{k}", parent=parent, child=f"l{k}", anchor_W=(x, 0.0, 0.0), axis_W=(0.0, -1.0, 0.0), drive=drive)
        )
        x += length
    return Scene(bodies=tuple(bodies), joints=tuple(joints))


def _arm_truth(time: float, stiffness: float, damping: float) -> Floats:
    """Angles from x (3,) [rad] after `time` [s], by Lagrange's equations in absolute angles and an integrator of order 8.

    M_ij = a_ij cos(th_i - th_j), a_ii = l_i^2 (m_i/3 + masses further out), a_ij = l_i l_j (m_j/2 + masses beyond j).
    """
    out = np.array([ARM_MASSES[k + 1 :].sum() for k in range(3)])
    lever = ARM_LENGTHS * (ARM_MASSES / 2 + out)
    a = np.outer(ARM_LENGTHS, lever)
    a = np.triu(a, 1) + np.triu(a, 1).T + np.diag(ARM_LENGTHS**2 * (ARM_MASSES / 3 + out))

    def rate(_: float, y: Floats) -> Floats:
        angle, speed = y[:3], y[3:]
        apart = angle[:, None] - angle[None, :]
        torque = stiffness * (ARM_TARGETS - np.diff(angle, prepend=0.0)) - damping * np.diff(speed, prepend=0.0)
        load = torque - np.append(torque[1:], 0.0) - G * lever * np.cos(angle) - (a * np.sin(apart)) @ speed**2
        return np.concatenate([speed, np.linalg.solve(a * np.cos(apart), load)])

    return np.asarray(solve_ivp(rate, (0.0, time), np.zeros(6), method="DOP853", rtol=1e-11, atol=1e-13).y[:3, -1])


@pytest.mark.parametrize(("damping", "dt", "name"), [(2.0, 1 / 240, "rk4"), (20.0, 1e-4, "rk4"), (20.0, 1e-3, "implicitfast")])
def test_a_driven_arm_takes_the_integrator_that_is_nearer_to_an_independent_one(damping: float, dt: float, name: str) -> None:
    """The outer link's inertia is 40 times what it is to the joint: only joint-space inertia tells what RK4 can carry."""
    scene, truth, errors = _arm(200.0, damping), _arm_truth(0.25, 200.0, damping), {}
    assert built(scene, TUNED, dt).resolved.integrator == name
    for integrator in ("rk4", "implicitfast"):
        simulation = built(scene, replace(TUNED, integrator=integrator), dt)
        try:
            simulation.step(round(0.25 / dt))
        except Diverged:
            errors[integrator] = math.inf
            continue
        q = state_of(simulation, scene).q_WB
        errors[integrator] = float(np.abs(-2 * np.arctan2(q[:, 2], q[:, 0]) - truth).max())
    other = "rk4" if name == "implicitfast" else "implicitfast"
    # Where RK4 resolves the fastest mode it errs by far less than a rule of first order; where it does not, it diverges.
    assert errors[name] < errors[other] / 10
    assert errors[name] < 2e-3


@pytest.mark.parametrize("z", [0.05, 0.5, 1.0, 1.9, 2.1, 2.7])
def test_a_damper_takes_the_rule_that_decays_nearest_to_the_closed_form(z: float) -> None:
    """w = w0 e^(-c t/I): RK4 up to c h/I = 2, where its factor of 1/3 a step is that of the implicit rule, and not beyond."""
    spin = Body(name="b", inertia=principal_inertia(1.0, 1.0, 1.0), w_WB=(0.0, 1.0, 0.0))
    damper = hinge_at("j", WORLD, "b", (0, 0, 0), spring=Spring(stiffness=0.0, damping=1e3 * z))
    scene, errors = Scene(bodies=(spin,), joints=(damper,)), {}
    for integrator in ("rk4", "implicitfast"):
        simulation = built(scene, replace(TUNED, integrator=integrator))
        simulation.step(1)
        errors[integrator] = abs(state_of(simulation, scene).w_WB[0, 1] - math.exp(-z))
    assert built(scene, TUNED).resolved.integrator == min(errors, key=lambda name: errors[name])


def test_a_spring_that_the_velocity_implicit_rule_would_blow_up_is_given_to_the_one_that_is_implicit_in_position() -> None:
    """Undamped at w h = 1, 1.4, 1.6, 3 and 250: below the limit of 2 the energy of the one keeps, beyond it the other fades.

    Semi-implicit in velocity, an amplitude stays within 1/sqrt(1 - (w h/2)^2) of what it was; implicit in position, it falls by
    1/sqrt(1 + (w h)^2) a step.
    """
    mass, dt, steps = Body(name="b", p_WB=(0.3, 0.0, 0.0)), 1e-3, 1000
    for z, name in ((1.0, "implicitfast"), (1.4, "implicitfast"), (1.6, "discrete"), (3.0, "discrete"), (250.0, "discrete")):
        # Damping that RK4 does not carry, of another coordinate, so that the spring alone decides.
        springs = {"b": Spring(stiffness=(z / dt) ** 2, damping=0.0), "c": Spring(stiffness=0.0, damping=10 / dt)}
        rails = tuple(
            Prismatic(name=k, parent=WORLD, child=k, anchor_W=(0, 0, 0), axis_W=(1, 0, 0), position=x, spring=springs[k])
            for k, x in (("b", 0.3), ("c", 0.0))
        )
        scene = Scene(bodies=(mass, Body(name="c")), joints=rails, gravity=(0.0, 0.0, 0.0))
        simulation, far = built(scene, TUNED, dt), 0.0
        assert simulation.resolved.integrator == name
        for _ in range(steps):
            simulation.step()
            far = max(far, abs(float(state_of(simulation, scene).p_WB[0, 0])))
        bound = 1 / math.sqrt(1 - z * z / 4) if name == "implicitfast" else 1.0
        assert far <= 0.3 * bound * (1 + 1e-9)
        # After 1000 steps at z = 1.6 and beyond nothing is left but rounding.
        assert name == "implicitfast" or abs(float(state_of(simulation, scene).p_WB[0, 0])) < 1e-15
    with pytest.raises(Diverged):
        built(scene, replace(TUNED, integrator="implicitfast"), dt).step(steps)


def test_a_light_slide_on_a_heavy_one_is_judged_by_the_inertia_that_its_damper_moves() -> None:
    """Linear, so that the matrix exponential is the truth. A damper between 10 kg and 0.1 kg moves 10 x 0.1/10.1 kg."""
    heavy, light = Body(name="heavy", mass=10.0), Body(name="light", mass=0.1, v_WB=(1.0, 0.0, 0.0))
    c, k, dt = 50.0, 400.0, 1e-3
    joints = tuple(
        Prismatic(name=child, parent=parent, child=child, anchor_W=(0, 0, 0), axis_W=(1.0, 0.0, 0.0), spring=spring)
        for parent, child, spring in (
            (WORLD, "heavy", Spring(stiffness=k, damping=0.0)),
            ("heavy", "light", Spring(stiffness=k, damping=c)),
        )
    )
    scene = Scene(bodies=(heavy, light), joints=joints, gravity=(0.0, 0.0, 0.0))
    K, C = np.array([[2 * k, -k], [-k, k]]), np.array([[c, -c], [-c, c]])
    inverse = np.diag([1 / 10.0, 1 / 0.1])
    motion = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ K, -inverse @ C]])
    truth = expm(motion * 0.1) @ np.array([0.0, 0.0, 0.0, 1.0])
    errors = {}
    for integrator in (None, "implicitfast"):
        simulation = built(scene, replace(TUNED, integrator=integrator), dt)
        simulation.step(100)
        errors[integrator] = float(np.abs(state_of(simulation, scene).p_WB[:, 0] - truth[:2]).max())
    # c h/m is .505: |R(-z) - e^-z| is z^5/120 = 2.7e-4 of the first step's decay; the implicit rule errs by z^2/2 = 13 %.
    assert errors[None] < errors["implicitfast"] / 100
