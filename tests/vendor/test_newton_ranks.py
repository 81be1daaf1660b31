"""Why Newton is best or worst of some cases, in newton's own words."""

from typing import Any

import numpy as np
import pytest

from tests.vendor.test_newton import G, mujoco, newton, run, wp
from tests.vendor.test_newton_declared import at, round_inertia

pytestmark = pytest.mark.newton
DT = 1 / 240


# What slides into rolling


def slid_into_rolling(impratio: float, corrections: int) -> float:
    """The most [m/s] by which a ball of .1 m that slides at 3 m/s is off 3 - mu g t, until it rolls at 3 * 5/7."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    t, mu = 0.02, 0.3
    config = newton.ModelBuilder.ShapeConfig(mu=mu, density=0.0, ke=1.0 / (1.2 * t) ** 2, kd=2.0 / t)
    stiff = {"mujoco:geom_solimp": (0.999, 0.999, 0.001, 0.5, 2.0)}
    builder.add_shape_plane(plane=(0.0, 0.0, 1.0, 0.0), width=0.0, length=0.0, cfg=config, custom_attributes=stiff)
    body = builder.add_body(xform=at(z=0.1), mass=1.0, inertia=round_inertia(0.004), lock_inertia=True)
    builder.add_shape_sphere(body, radius=0.1, cfg=config, custom_attributes=stiff)
    builder.joint_qd[0] = 3.0
    builder.body_qd[body] = wp.spatial_vector(3.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    model = builder.finalize(device="cpu")
    solver = mujoco(model, cone="elliptic", impratio=impratio, integrator="euler", nconmax=16, njmax=64)
    solver.mjw_model.opt.noslip_iterations = corrections
    states, off = [model.state(), model.state()], 0.0
    with wp.ScopedCapture(device="cpu") as capture:
        solver.step(states[0], states[1], model.control(), None, DT)
        solver.step(states[1], states[0], model.control(), None, DT)
    for k in range(1, 121):
        wp.capture_launch(capture.graph)
        off = max(off, abs(float(states[0].body_qd.numpy()[0, 0]) - max(3.0 - mu * G * 2 * k * DT, 15 / 7)))
    return off


def test_the_slip_correction_that_newton_has_no_word_for_rolls_a_ball_as_coulomb_says_to_a_step_of_friction() -> None:
    step = 0.3 * G * DT
    assert slid_into_rolling(1e-6, 5) < step
    assert slid_into_rolling(10.0, 0) > 5 * step
    assert slid_into_rolling(10.0, 5) > 5 * step


# What moves smoothly


def swung(integrator: str, refined: int = 1) -> float:
    """How far [m] a rod's centre is above its hinge .7 s after it was level. Args: refined: steps in one of 1/240 s."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    rod = builder.add_link(xform=at(x=0.5), mass=1.0, inertia=round_inertia(1 / 12), lock_inertia=True)
    joint = builder.add_joint_revolute(-1, rod, axis=(0, 1, 0), child_xform=at(x=-0.5), armature=0.0)
    builder.add_articulation([joint])
    model = builder.finalize(device="cpu")
    return float(run(model, mujoco(model, integrator=integrator), 168 * refined, DT / refined)[0][-1][2])


def spinning_top(integrator: str) -> float:
    """The speed [rad/s] of a heavy top on a ball joint after two seconds, which starts at 200 about its axis."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    top = builder.add_link(mass=1.0, inertia=wp.mat33(0.002, 0, 0, 0, 0.002, 0, 0, 0, 0.001), lock_inertia=True)
    lean = wp.quat_from_axis_angle(wp.vec3(0.0, 1.0, 0.0), 0.5)
    joint = builder.add_joint_ball(-1, top, parent_xform=wp.transform((0, 0, 0), lean), child_xform=at(z=-0.05))
    builder.add_articulation([joint])
    builder.joint_qd[2] = 200.0
    model = builder.finalize(device="cpu")
    state = model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    return float(np.linalg.norm(run(model, mujoco(model, integrator=integrator), 480, DT)[1][-1][3:]))


def test_rk4_swings_a_rod_a_hundred_times_as_well_as_euler_does_and_keeps_a_top_that_diverges_under_them() -> None:
    fine = swung("rk4", refined=4)
    assert swung("rk4") == pytest.approx(fine, abs=1e-5)  # roundings of 168 steps
    for name in ("euler", "implicitfast"):
        assert abs(swung(name) - fine) > 1e-3
    assert spinning_top("rk4") == pytest.approx(200.0, rel=0.01)
    for name in ("euler", "implicitfast"):
        assert not spinning_top(name) < 400.0


# What is shot


def shot(dt: float, gap: float = 0.0) -> bool:
    """Does a ball of 2 cm at 60 m/s pass a wall 1 cm thick? Args: gap: how far from a shape contacts are looked for [m]."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    config = newton.ModelBuilder.ShapeConfig(mu=0.0, density=0.0, gap=gap)
    builder.add_shape_box(-1, xform=at(x=0.0), hx=0.005, hy=1.0, hz=1.0, cfg=config)
    body = builder.add_body(xform=at(x=-1.03), mass=1.0, inertia=round_inertia(4e-5), lock_inertia=True)
    builder.add_shape_sphere(body, radius=0.01, cfg=config)
    builder.joint_qd[0] = 60.0
    builder.body_qd[body] = wp.spatial_vector(60.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    model = builder.finalize(device="cpu")
    solver = mujoco(model, integrator="euler", nconmax=16, njmax=64)
    return bool(run(model, solver, 2 * round(0.025 / dt), dt)[0][0, 0] > 0.0)


def test_a_ball_passes_a_thin_wall_unless_its_way_in_a_step_is_shorter_than_it_and_a_gap_does_not_help() -> None:
    assert shot(1 / 240)
    assert shot(1 / 240, gap=0.3)
    assert not shot(1 / 19200)


# What single precision leaves


def column(share: float) -> Any:
    """Speeds of five boxes on each other after 3 s under elliptic cones. Args: share: impedance of contacts."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    stiff = {"mujoco:geom_solimp": (share, share, 0.001, 0.5, 2.0)}
    config = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0, ke=1.0 / 0.024**2, kd=100.0)
    builder.add_shape_plane(plane=(0.0, 0.0, 1.0, 0.0), width=0.0, length=0.0, cfg=config, custom_attributes=stiff)
    for k in range(5):
        body = builder.add_body(xform=at(z=0.1 + 0.2 * k), mass=1.0, inertia=round_inertia(1 / 150), lock_inertia=True)
        builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config, custom_attributes=stiff)
    return builder.finalize(device="cpu")


def test_what_rests_trembles_over_mujoco_warp_and_not_over_mujoco_in_double_precision() -> None:
    speeds = {}
    for double in (False, True):
        model = column(0.999)
        solver = mujoco(model, cone="elliptic", impratio=10.0, integrator="euler", nconmax=64, njmax=512, use_mujoco_cpu=double)
        speeds[double] = float(np.abs(run(model, solver, 720, DT, graph=not double)[1][:, :3]).max())
    assert speeds[False] > 1e-3
    assert speeds[True] < 1e-2 * speeds[False]  # poses are single between its steps


def dip(pressed: float, double: bool = False) -> float:
    """How far [mm] the top of ten boxes comes down within half a second. Args: pressed: how far each is in the next [m]."""
    builder, pitch = newton.ModelBuilder(gravity=(0.0, 0.0, -G)), 0.2 - pressed
    config = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0)
    builder.add_shape_plane(plane=(0.0, 0.0, 1.0, 0.0), width=0.0, length=0.0, cfg=config)
    for k in range(10):
        body = builder.add_body(xform=at(z=0.1 + pitch * k), mass=1.0, inertia=round_inertia(1 / 150), lock_inertia=True)
        builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config)
    model = builder.finalize(device="cpu")
    solver, low = mujoco(model, nconmax=128, njmax=1024, use_mujoco_cpu=double), np.inf
    states = [model.state(), model.state()]
    for _ in range(60):
        solver.step(states[0], states[1], model.control(), None, DT)
        solver.step(states[1], states[0], model.control(), None, DT)
        low = min(low, float(states[0].body_q.numpy()[-1][2]))
    return 1e3 * (0.1 + 9 * pitch - low)


def test_boxes_that_touch_fall_a_step_longer_than_the_next_below_over_mujoco_warp_alone() -> None:
    each_a_step_later = 1e3 * 55 * G * DT**2
    assert dip(1e-5) > each_a_step_later
    assert dip(1e-5, double=True) < each_a_step_later / 4
    assert dip(1e-4) < each_a_step_later / 4
