"""What Newton's adapter says of it, in newton's own words."""

import math
import warnings
from typing import Any

import numpy as np
import pytest

wp = pytest.importorskip("warp", reason="installed when it is asked for")
newton = pytest.importorskip("newton", reason="installed when it is asked for")
pytestmark = pytest.mark.newton

G = 9.81


def ball_in_flight(spin: tuple[float, float, float]) -> Any:
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    builder.add_body(mass=2.0, inertia=wp.mat33(0.3, 0, 0, 0, 0.3, 0, 0, 0, 0.3), lock_inertia=True)
    builder.joint_qd[3:6] = spin
    builder.body_qd[0] = wp.spatial_vector(0.0, 0.0, 0.0, *spin)
    return builder.finalize(device="cpu")


def box_on_plane(ground: float, box: float, slope: float, **shape: float) -> Any:
    """A box of 0.2 m and 1 kg at rest on a plane that gravity is tilted against."""
    builder = newton.ModelBuilder(gravity=(G * math.sin(slope), 0.0, -G * math.cos(slope)))
    config = newton.ModelBuilder.ShapeConfig
    still = wp.transform((0.0, 0.0, 0.0), wp.quat_identity())
    builder.add_shape_plane(None, xform=still, width=0.0, length=0.0, cfg=config(mu=ground, density=0.0, **shape))
    body = builder.add_body(
        xform=wp.transform((0.0, 0.0, 0.1), wp.quat_identity()),
        mass=1.0,
        inertia=wp.mat33(1 / 150, 0, 0, 0, 1 / 150, 0, 0, 0, 1 / 150),
        lock_inertia=True,
    )
    builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config(mu=box, density=0.0, **shape))
    return builder.finalize(device="cpu")


def mujoco(model: Any, **options: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return newton.solvers.SolverMuJoCo(model, **options)


def run(model: Any, solver: Any, steps: int, dt: float, graph: bool = True) -> tuple[Any, Any]:
    """Poses and velocities after an even number of steps, whose kernels are captured or called one by one."""
    states, control = [model.state(), model.state()], model.control()
    pipeline = newton.CollisionPipeline(model) if isinstance(solver, newton.solvers.SolverXPBD) else None
    contacts = None if pipeline is None else pipeline.contacts()

    def two() -> None:
        for here, there in (states, states[::-1]):
            if pipeline is not None:
                pipeline.collide(here, contacts)
            solver.step(here, there, control, contacts, dt)

    if graph:
        with wp.ScopedCapture(device="cpu") as capture:
            two()
    for _ in range(steps // 2):
        if graph:
            wp.capture_launch(capture.graph)
        else:
            two()
    return states[0].body_q.numpy().copy(), states[0].body_qd.numpy().copy()


def test_the_kernels_of_a_step_give_the_same_bits_from_a_graph_as_one_by_one() -> None:
    for make in (mujoco, newton.solvers.SolverXPBD):
        answers = []
        for graph in (True, False):
            model = box_on_plane(0.3, 0.3, math.radians(20.0))
            answers.append(run(model, make(model), 40, 1 / 240, graph))
        assert (answers[0][0] == answers[1][0]).all()
        assert (answers[0][1] == answers[1][1]).all()
        assert abs(answers[0][1][0, 0]) > 0.05, "it slides"


def test_of_two_coefficients_of_friction_mujoco_takes_the_greater_and_xpbd_the_mean() -> None:
    slope, ways = math.radians(20.0), {}
    for name, make in (("mujoco", mujoco), ("xpbd", newton.solvers.SolverXPBD)):
        for ground, box in ((0.1, 0.3), (0.3, 0.3), (0.2, 0.2)):
            model = box_on_plane(ground, box, slope)
            ways[name, ground, box] = float(run(model, make(model), 240, 1 / 240)[0][0, 0])
    # From rest at mu it goes g (sin a - mu cos a) t^2/2 = 1.678 - 4.609 mu metres in a second.
    assert ways["mujoco", 0.1, 0.3] == pytest.approx(ways["mujoco", 0.3, 0.3], abs=0.02)
    assert ways["mujoco", 0.2, 0.2] - ways["mujoco", 0.1, 0.3] > 0.3
    assert ways["xpbd", 0.1, 0.3] == pytest.approx(ways["xpbd", 0.2, 0.2], abs=0.02)
    assert ways["xpbd", 0.1, 0.3] - ways["xpbd", 0.3, 0.3] > 0.3


def test_restitution_is_xpbd_s_alone() -> None:
    speeds = {}
    for name, make in (
        ("mujoco", mujoco),
        ("xpbd", lambda model: newton.solvers.SolverXPBD(model, enable_restitution=True)),
        ("xpbd as it comes", newton.solvers.SolverXPBD),
    ):
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
        config = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0, restitution=0.8)
        still = wp.transform((0.0, 0.0, 0.0), wp.quat_identity())
        builder.add_shape_plane(None, xform=still, width=0.0, length=0.0, cfg=config)
        ball = builder.add_body(
            xform=wp.transform((0.0, 0.0, 0.3), wp.quat_identity()),
            mass=1.0,
            inertia=wp.mat33(0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01),
            lock_inertia=True,
        )
        builder.add_shape_sphere(ball, radius=0.1, cfg=config)
        builder.joint_qd[2], builder.body_qd[0] = -2.0, wp.spatial_vector(0.0, 0.0, -2.0, 0.0, 0.0, 0.0)
        model = builder.finalize(device="cpu")
        speeds[name] = float(run(model, make(model), 240, 1e-3)[1][0, 2])
    assert speeds["xpbd"] == pytest.approx(1.6, rel=0.01)
    assert abs(speeds["xpbd as it comes"]) < 0.1
    assert speeds["mujoco"] < 0.5


def test_each_step_over_mujoco_changes_a_ball_s_spin_by_some_3e_7_of_itself() -> None:
    steps = 960
    for dt in (1 / 240, 1e-3):
        model = ball_in_flight((1.0, 2.0, -3.0))
        spin = run(model, mujoco(model), steps, dt)[1][0, 3:]
        change = np.linalg.norm(spin) / math.sqrt(14.0) - 1.0
        assert 3e-8 < abs(change) / steps < 1e-6
