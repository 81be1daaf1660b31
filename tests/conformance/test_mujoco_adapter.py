"""What is particular to MuJoCo: free bodies, rays and pictures, effects, sub-steps, state kept in `MjData`."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.adapters.mujoco import ADAPTER
from plumbline.adapters.mujoco.simulation import MujocoSimulation
from plumbline.harness.adapter import Diverged, Settings, SettingsError, Unsupported
from plumbline.harness.scene import (
    Body,
    Box,
    Camera,
    Capsule,
    ConvexHull,
    Cylinder,
    Effect,
    PlacedShape,
    Plane,
    Scene,
    Shape,
    Sphere,
    Surface,
    TriangleMesh,
    axis_angle,
    multiply,
)
from plumbline.harness.trajectory import Floats, State
from tests.conformance.mujoco_scenes import BOTH, DEFAULT, TUNED, G, built, matrix, on_ground, shaped_body, stack, state_of

TURNED = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
TETRAHEDRON = ((0.0, 0.0, 0.4), (0.4, 0.0, 0.0), (-0.2, 0.35, 0.0), (-0.2, -0.35, 0.0))
FACES = ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2))


def test_a_fall_errs_by_g_dt_t_half_on_default_and_by_rounding_on_tuned() -> None:
    scene = Scene(bodies=(Body(name="body", p_WB=(1.0, 2.0, 3.0), v_WB=(1.0, 2.0, 3.0)),))
    for settings, expected in ((DEFAULT, -G * 1e-3 / 2), (TUNED, 0.0)):
        simulation = built(scene, settings)
        simulation.step(1000)
        error = state_of(simulation, scene).p_WB[0] - (2.0, 4.0, 6.0 - G / 2)
        # Semi-implicit Euler sums k g dt^2 over 1000 steps: exactly g dt t/2 too low; 1e-11 is rounding of 1000 additions.
        np.testing.assert_allclose(error, (0.0, 0.0, expected), rtol=0, atol=1e-11)


def test_a_top_with_products_of_inertia_follows_the_equations_of_euler() -> None:
    R = matrix(np.array(TURNED))
    tensor = R @ np.diag([0.1, 0.2, 0.25]) @ R.T
    tensor = (tensor + tensor.T) / 2
    body = Body(name="top", mass=2.0, inertia=tensor.tolist(), p_WB=(1.0, 2.0, 3.0), q_WB=TURNED, w_WB=(3.0, 1.0, -2.0))
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))
    simulation = built(scene, TUNED)
    np.testing.assert_allclose(state_of(simulation, scene).w_WB[0], body.w_WB, atol=1e-14)
    simulation.step(1000)
    end = state_of(simulation, scene)
    R_end = matrix(end.q_WB[0])
    tensor_W = R_end @ tensor @ R_end.T
    momentum = tensor_W @ end.w_WB[0]
    start = R @ tensor @ R.T @ np.array(body.w_WB)
    # RK4 at w dt = 4e-3 errs by (w dt)^4 = 2e-10 a radian at most.
    np.testing.assert_allclose(momentum, start, atol=1e-9)
    assert end.w_WB[0] @ momentum == pytest.approx(np.array(body.w_WB) @ start, rel=1e-9)


@BOTH
def test_angular_damping_of_an_anisotropic_body_is_the_law_w_dot_minus_c_w(settings: Settings) -> None:
    R = matrix(np.array(TURNED))
    tensor = R @ np.diag([0.1, 0.2, 0.25]) @ R.T
    tensor = (tensor + tensor.T) / 2
    body = Body(
        name="b", inertia=tensor.tolist(), w_WB=(3.0, 1.0, -2.0), v_WB=(1.0, 0.0, 0.0), linear_damping=0.5, angular_damping=0.7
    )
    scene = Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))
    simulation = built(scene, settings)
    simulation.step(1000)
    end = state_of(simulation, scene)

    def rate(_: float, w: Floats) -> Floats:
        return np.linalg.solve(tensor, -np.cross(w, tensor @ w)) - 0.7 * w

    w_B = solve_ivp(rate, (0.0, 1.0), body.w_WB, rtol=1e-11, atol=1e-11).y[:, -1]
    # First order: c^2 dt/2 and the gyroscopic term |w|^2 dt/2 = 7e-3 a second at most.
    np.testing.assert_allclose(matrix(end.q_WB[0]).T @ end.w_WB[0], w_B, atol=1e-8 if settings is TUNED else 7e-3)
    assert end.v_WB[0, 0] == pytest.approx(math.exp(-0.5), abs=1e-9 if settings is TUNED else 0.5**2 * 1e-3)


def test_rays_meet_every_shape_at_the_closed_form_and_stop_at_their_range() -> None:
    o, d = (
        np.array([[0.0, 0.0, 3.0], [0.0, 0.0, 3.0], [5.0, 0.0, 0.0]]),
        np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]),
    )
    tops: list[tuple[Shape, float, float]] = [
        (Sphere(radius=0.4), 2.6, 4.6),
        (Box(half_extents=(0.2, 0.3, 0.4)), 2.6, 4.8),
        (Capsule(radius=0.2, half_length=0.3), 2.5, 4.8),
        (Cylinder(radius=0.3, half_length=0.2), 2.8, 4.7),
        (Plane(), 3.0, math.inf),
        (ConvexHull(vertices=TETRAHEDRON), 2.6, 4.6),
        (TriangleMesh(vertices=TETRAHEDRON, faces=FACES), 2.6, 4.6),
    ]
    for shape, down, across in tops:
        body = Body(name="target", motion="static", p_WB=(10.0, 0.0, 0.0), q_WB=TURNED, collision=(PlacedShape(shape=shape),))
        scene = Scene(bodies=(Body(name="other", motion="static"), body))
        R = matrix(np.array(TURNED))
        hits = built(scene).cast(o @ R.T + (10.0, 0.0, 0.0), d @ R.T, 10.0)
        # Meshes are held in single precision: 2^-24 of half a metre; the last ray runs along the tetrahedron's foot.
        np.testing.assert_allclose(hits.distance[:2], (down, math.inf), atol=1e-7)
        np.testing.assert_array_equal(hits.body[:2], (1, -1))
        if not isinstance(shape, ConvexHull | TriangleMesh | Plane):
            assert hits.distance[2] == pytest.approx(across, abs=1e-12)
            np.testing.assert_allclose(hits.normal_W[2], R @ (1.0, 0.0, 0.0), atol=1e-12)
        # The engine's own cutoff leaves out shapes, not hits.
        assert not np.isfinite(built(scene).cast(o[:1] @ R.T + (10.0, 0.0, 0.0), d[:1] @ R.T, down - 0.01).distance).any()


def test_depth_agrees_with_rays_through_a_tilted_pinhole_off_its_centre() -> None:
    camera = Camera(
        name="c",
        body="mount",
        rate=1.0,
        width=80,
        height=60,
        focal_x=50,
        focal_y=55,
        centre_x=42,
        centre_y=27,
        p_BS=(0.1, 0, 0),
    )
    wall = Body(
        name="wall", motion="static", p_WB=(0.0, 0.0, 4.0), collision=(PlacedShape(shape=Box(half_extents=(9.0, 9.0, 0.5))),)
    )
    mount = Body(name="mount", motion="static", p_WB=(0.2, 0.1, -1.0), q_WB=axis_angle((0.0, 1.0, 0.0), 0.1))
    simulation = built(Scene(bodies=(wall, mount)))
    try:
        depth = simulation.render(camera).depth
    except Unsupported as refused:
        pytest.skip(str(refused))
    finally:
        simulation.close()
    R = matrix(np.array(mount.q_WB))
    u, v = np.meshgrid(np.arange(80) + 0.5, np.arange(60) + 0.5)
    ray = np.stack([(u - 42) / 50, (v - 27) / 55, np.ones_like(u)], axis=-1) @ R.T
    eye = np.array(mount.p_WB) + R @ (0.1, 0.0, 0.0)
    # Reversed z in single precision: z^2/near 2^-24 = 2e-4 at 5 m and near = .01.
    np.testing.assert_allclose(depth, (3.5 - eye[2]) / ray[..., 2], atol=3e-4)


def test_a_concave_mesh_is_seen_by_rays_and_refused_in_contact() -> None:
    # A roof turned upside down: the middle vertex lies below the plane of the others.
    vertices = (*TETRAHEDRON[1:], (0.0, 0.0, 0.1), (0.0, 0.0, -0.4))
    faces = ((0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4))
    dented = TriangleMesh(vertices=(*vertices[:3], (0.0, 0.0, -0.1), vertices[4]), faces=faces)
    static = Body(name="dent", motion="static", material="ground", collision=(PlacedShape(shape=dented),))
    middle = np.mean([vertices[0], vertices[1], (0.0, 0.0, -0.1)], axis=0)
    hits = built(Scene(bodies=(static,))).cast(middle[None] * (1, 1, 0) + (0, 0, 1), np.array([[0.0, 0.0, -1.0]]), 5.0)
    # Single precision of the vertices.
    assert hits.distance[0] == pytest.approx(1.0 - middle[2], abs=1e-6)
    ball = shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 1.0))
    with pytest.raises(Unsupported, match="not convex"):
        built(Scene(bodies=(static, ball), surfaces=(Surface(between=("ground", "block")),)))
    built(
        Scene(
            bodies=(replace(static, collision=(PlacedShape(shape=TriangleMesh(vertices=vertices, faces=faces)),)), ball),
            surfaces=(Surface(between=("ground", "block")),),
        )
    )


@BOTH
def test_restored_runs_repeat_bit_for_bit_whatever_is_read_in_between(settings: Settings) -> None:
    scene = stack(6)
    first, second = built(scene, settings), built(scene, settings)
    first.step(300)
    saved = first.save()
    first.step(200)
    expected = state_of(first, scene)
    first.restore(saved)
    second.step(300)
    for simulation in (first, second):
        for _ in range(200):
            simulation.step()
            simulation.contacts()
            simulation.cast(np.array([[0.0, 0.0, 5.0]]), np.array([[0.0, 0.0, -1.0]]), 10.0)
            got = state_of(simulation, scene)
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            np.testing.assert_array_equal(getattr(got, name), getattr(expected, name))


def test_a_state_that_is_not_finite_is_raised_not_reset() -> None:
    scene = Scene(bodies=(Body(name="b"),))
    simulation = built(scene)
    simulation.wrench(np.array([[1e308, 0.0, 0.0]]), np.zeros((1, 3)))
    with pytest.raises(Diverged, match="BADQACC"):
        simulation.step()
    with pytest.raises(Diverged):
        simulation.step()


def test_only_the_effects_called_for_are_on_and_the_rest_is_named() -> None:
    box = shaped_body("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1))
    scene = on_ground(box, mu=0.5)
    off = built(replace(scene, narrow=Effect.CONTACT | Effect.FRICTION | Effect.GRAVITY))
    assert {"contact", "gravity", "autoreset"} <= set(off.resolved.options["disabled"])
    assert len(off.contacts()) == 0
    assert Effect.GYROSCOPIC in {notice.effect for notice in off.warnings() if notice.kind == "surplus"}
    plain = built(replace(scene, widen=Effect.CONTINUOUS_COLLISION))
    assert Effect.CONTINUOUS_COLLISION in {notice.effect for notice in plain.warnings() if notice.kind == "missing"}
    fast = built(replace(scene, widen=Effect.CONTINUOUS_COLLISION), TUNED)
    assert fast.resolved.options["enabled"] == ["speculative"]
    slippery = replace(scene, narrow=Effect.FRICTION, bodies=(scene.bodies[0], replace(box, v_WB=(1.0, 0.0, 0.0))))
    simulation = built(slippery)
    simulation.step(100)
    assert state_of(simulation, slippery).v_WB[1, 0] == pytest.approx(1.0, abs=1e-12)


def test_settings_out_of_range_name_field_value_and_expectation() -> None:
    scene = Scene(bodies=(Body(name="b"),))
    for settings, said in (
        (Settings(integrator="verlet"), "integrator 'verlet'.*euler"),
        (Settings(options={"impratio": -1}), "'impratio' is -1, expected"),
        (Settings(options={"cone": "round"}), "'cone' is 'round', expected one of pyramidal, elliptic"),
        (Settings(options={"multiccd": 1}), "'multiccd' is 1, expected true or false"),
    ):
        with pytest.raises(SettingsError, match=said):
            ADAPTER.build(scene, settings)


def test_substeps_divide_the_step() -> None:
    scene = Scene(bodies=(Body(name="b"),))
    simulation = ADAPTER.build(scene, Settings(dt=0.01, substeps=4))
    simulation.step(100)
    # g h t/2 below the parabola with h = dt/4.
    assert state_of(simulation, scene).p_WB[0, 2] == pytest.approx(-G / 2 - G * 0.0025 / 2, abs=1e-11)
    assert simulation.resolved.dt == pytest.approx(0.01)


@BOTH
def test_substeps_are_the_engine_s_own_steps_under_a_wrench_that_is_held_and_one_of_them_changes_nothing(
    settings: Settings,
) -> None:
    """What a step of n sub-steps gives is, bit for bit, what n steps of dt/n give that are told the same."""
    box = shaped_body("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.099), v=(0.5, 0.0, 0.0))
    scene, dt = on_ground(box, mu=0.5), 1 / 64
    push = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, -1.0]])

    def after(substeps: int | None, step: float, calls: int) -> tuple[MujocoSimulation, State]:
        simulation = ADAPTER.build(scene, replace(settings, dt=step, substeps=substeps))
        simulation.wrench(push, np.zeros((2, 3)))
        for _ in range(calls):
            simulation.step()
        return simulation, state_of(simulation, scene)

    for one, other in (((None, dt, 32), (1, dt, 32)), ((4, dt, 32), (None, dt / 4, 128))):
        (simulation, a), (_, b) = after(*one), after(*other)
        assert simulation.resolved.substeps == (one[0] or 1)
        assert simulation.resolved.dt == dt
        for field in ("p_WB", "q_WB", "v_WB", "w_WB"):
            np.testing.assert_array_equal(getattr(a, field), getattr(b, field))
