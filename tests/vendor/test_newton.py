"""What Newton's adapter says of it, in newton's own words."""

import math
import warnings
from typing import Any

import numpy as np
import pytest

wp = pytest.importorskip("warp", reason="installed when it is asked for")
wp.config.enable_backward = False
newton = pytest.importorskip("newton", reason="installed when it is asked for")
# On a new machine kernels are compiled here, one for minutes.
pytestmark = [pytest.mark.newton, pytest.mark.timeout(1800)]

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


def box_on(below: str) -> Any:
    """A box of 0.2 m and 1 kg at rest on a block a metre wide, whose top is at z = 0: a box, its hull, or a round one."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -G))
    config, half = newton.ModelBuilder.ShapeConfig(mu=0.5, density=0.0), 0.5
    at = wp.transform((0.0, 0.0, -half), wp.quat_identity())
    if below == "box":
        builder.add_shape_box(-1, xform=at, hx=half, hy=half, hz=half, cfg=config)
    elif below == "cylinder":
        builder.add_shape_cylinder(-1, xform=at, radius=half, half_height=half, cfg=config)
    else:
        corners = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)], dtype=np.float32)
        sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = np.array([face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))], dtype=np.int32)
        mesh = newton.Mesh(corners, faces.ravel(), compute_inertia=False)
        builder.add_shape_convex_hull(-1, xform=at, mesh=mesh, cfg=config)
    body = builder.add_body(
        xform=wp.transform((0.0, 0.0, 0.1), wp.quat_identity()),
        mass=1.0,
        inertia=wp.mat33(1 / 150, 0, 0, 0, 1 / 150, 0, 0, 0, 1 / 150),
        lock_inertia=True,
    )
    builder.add_shape_box(body, hx=0.1, hy=0.1, hz=0.1, cfg=config)
    return builder.finalize(device="cpu")


def mujoco(model: Any, **options: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return newton.solvers.SolverMuJoCo(model, **options)


def run(model: Any, solver: Any, steps: int, dt: float, graph: bool = True) -> tuple[Any, Any]:
    """Poses and velocities after an even number of steps, whose kernels are captured or called one by one."""
    states, control = [model.state(), model.state()], model.control()
    own = isinstance(solver, newton.solvers.SolverXPBD) or not solver._use_mujoco_contacts
    pipeline = newton.CollisionPipeline(model) if own else None
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


def test_a_box_sinks_on_the_one_point_that_mujoco_warp_finds_of_hull_and_cylinder_and_stays_on_newton_s_four() -> None:
    for below in ("box", "hull", "cylinder"):
        sunk = {}
        for whose in (True, False):
            solver = mujoco(model := box_on(below), use_mujoco_contacts=whose, nconmax=64, njmax=256)
            sunk[whose] = 0.1 - float(run(model, solver, 720, 1 / 240)[0][0, 2])
            points = int(solver.mjw_data.nacon.numpy()[0])
            assert points == (4 if below == "box" or not whose else 1)
        assert abs(sunk[False]) < 1e-4
        assert (sunk[True] > 3e-3) == (below != "box")


def test_a_pyramid_of_friction_lets_a_box_slide_farther_towards_its_edges() -> None:
    ways = {}
    for cone in ("pyramidal", "elliptic"):
        for degrees in (0.0, 45.0):
            model = box_on_plane(0.5, 0.5, 0.0)
            a = math.radians(degrees)
            velocity = (2.0 * math.cos(a), 2.0 * math.sin(a), 0.0)
            model.joint_qd.assign(np.array([*velocity, 0.0, 0.0, 0.0], dtype=np.float32))
            model.body_qd.assign(np.array([[*velocity, 0.0, 0.0, 0.0]], dtype=np.float32))
            place = run(model, mujoco(model, cone=cone), 240, 1 / 240)[0][0]
            ways[cone, degrees] = math.hypot(place[0], place[1])
    # v^2/(2 mu g) = .408 m; towards the edge of a pyramid mu is 1/sqrt(2) of that.
    assert ways["pyramidal", 45.0] / ways["pyramidal", 0.0] == pytest.approx(math.sqrt(2.0), rel=0.03)
    assert ways["elliptic", 45.0] / ways["elliptic", 0.0] == pytest.approx(1.0, rel=0.01)


def test_a_ray_of_single_precision_meets_a_sphere_some_micrometres_off() -> None:
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    builder.add_shape_sphere(-1, xform=wp.transform((0.0, 0.0, 0.0), wp.quat_identity()), radius=0.5)
    model = builder.finalize(device="cpu")
    model.bvh_refit_shapes(model.state())
    angles = np.linspace(-0.045, 0.045, 64)
    ways = np.stack([np.sin(angles), np.zeros(64), -np.cos(angles)], axis=1)
    distance = wp.full(64, -1.0, dtype=float, device="cpu")
    newton.intersect_ray(
        model,
        ray_origins=wp.array(np.tile([0.0, 0.0, 10.0], (64, 1)).astype(np.float32), dtype=wp.vec3, device="cpu"),
        ray_directions=wp.array(ways.astype(np.float32), dtype=wp.vec3, device="cpu"),
        ray_worlds=wp.zeros(64, dtype=wp.int32, device="cpu"),
        out_dist=distance,
        out_shape_id=wp.full(64, -1, dtype=wp.int32, device="cpu"),
        out_normal=wp.zeros(64, dtype=wp.vec3, device="cpu"),
        fast_math=False,
    )
    exact = 10.0 * np.cos(angles) - np.sqrt(0.25 - (10.0 * np.sin(angles)) ** 2)
    off = np.abs(distance.numpy() - exact)
    assert off.max() < 1e-4
    assert off.max() > 1e-6


def test_buffers_that_are_too_small_are_told_in_overflow_alone() -> None:
    """Four points for which there is room for two: the step goes on without a word."""
    for room, told in ((16, False), (2, True)):
        solver = mujoco(model := box_on_plane(0.5, 0.5, 0.0), nconmax=room, njmax=64)
        run(model, solver, 4, 1 / 240)
        assert bool(solver.mjw_data.overflow.numpy().any()) == told
