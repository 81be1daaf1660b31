"""What is particular to DART: its settings and sub-steps, damping, rays, effects, and what its worlds share."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.adapter import Diverged, Settings, SettingsError
from plumbline.harness.conformance.closed_forms import first_hit
from plumbline.harness.conformance.frames import angle_between, rotation
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    PlacedShape,
    Plane,
    Revolute,
    Scene,
    Shape,
    Sphere,
    axis_angle,
    multiply,
    principal_inertia,
)

pytest.importorskip("dartpy", reason="DART is not installed")

from plumbline.adapters.dart import ADAPTER
from plumbline.adapters.dart.simulation import DartSimulation
from plumbline.adapters.dart.solvers import SOLVERS
from plumbline.cases import system_rays
from tests.conformance.dart_scenes import (
    CUBE,
    DEFAULT,
    PD,
    TUNED,
    box_body,
    calls_of,
    free_body,
    ground_body,
    solid_body,
    state_after,
    state_of,
    surface_law,
    with_options,
)


def test_a_kinematic_body_keeps_its_velocity_and_carries_what_is_jointed_to_it() -> None:
    arm = free_body("arm", (0.0, 0.0, -1.0), v_WB=(1.0, 0.0, 0.0))
    cart = Body(name="cart", motion="kinematic", v_WB=(1.0, 0.0, 0.0))
    joint = Revolute(name="j", parent="cart", child="arm", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    end = state_after(Scene(bodies=(arm, cart), joints=(joint,)), 2.0)
    np.testing.assert_allclose(end.p_WB, [(2.0, 0.0, -1.0), (2.0, 0.0, 0.0)], atol=1e-9)
    table = solid_body(
        "table", Cylinder(radius=1.0, half_length=0.1), (0.0, 0.0, -0.1), "g", motion="kinematic", w_WB=(0.0, 0.0, 2.0)
    )
    spun = state_after(Scene(bodies=(table, box_body()), surfaces=(surface_law(),)), 1.0)
    assert angle_between(spun.q_WB[0], axis_angle((0.0, 0.0, 1.0), 2.0)) < 1e-12
    np.testing.assert_allclose(spun.w_WB[0], (0.0, 0.0, 2.0), atol=0.0)
    # The box at the centre has gripped long ago and turns with the table.
    assert abs(spun.w_WB[1, 2] - 2.0) < 1e-3


def test_damping_of_an_asymmetric_body_is_a_rate_and_not_a_torque() -> None:
    inertia = ((0.3, 0.05, 0.02), (0.05, 0.4, 0.03), (0.02, 0.03, 0.5))
    w = np.array([1e-4, 2e-4, 3e-4])
    body = Body(name="x", inertia=inertia, v_WB=(1.0, 2.0, 3.0), w_WB=tuple(w), linear_damping=0.5, angular_damping=1.0)
    end = state_after(Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0)), 1.0)
    # Implicit first order errs by c^2 t dt/2 = 5e-4; gyroscopic terms are w t = 1e-4 of w.
    np.testing.assert_allclose(end.v_WB[0], np.exp(-0.5) * np.array([1.0, 2.0, 3.0]), rtol=6e-4)
    np.testing.assert_allclose(end.w_WB[0], np.exp(-1.0) * w, rtol=1e-3)


def test_damping_as_a_force_is_implicit_at_any_step() -> None:
    """Step by step v / (1 + c dt): at c dt = 1/2 the explicit force would leave 1/2 of the speed, the implicit one 2/3.

    Products of inertia turn the axis by w dt: 1e-6 rad keep that out of seven digits.
    """
    inertia = ((0.3, 0.05, 0.02), (0.05, 0.4, 0.03), (0.02, 0.03, 0.5))
    v, w = np.array([1.0, 2.0, 3.0]), np.array([1e-6, 2e-6, 3e-6])
    body = Body(name="x", inertia=inertia, v_WB=tuple(v), w_WB=tuple(w), linear_damping=50.0, angular_damping=25.0)
    end = state_after(Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0)), 0.03, with_options(dt=0.01))
    np.testing.assert_allclose(end.v_WB[0], v / 1.5**3, rtol=1e-9)
    np.testing.assert_allclose(end.w_WB[0], w / 1.25**3, rtol=1e-6)


SHAPES: tuple[Shape, ...] = (
    Sphere(radius=0.4),
    Box(half_extents=(0.3, 0.2, 0.4)),
    Capsule(radius=0.2, half_length=0.3),
    Cylinder(radius=0.3, half_length=0.4),
    Plane(normal=(1.0, 2.0, 3.0)),
    ConvexHull(vertices=tuple((3 * x, 2 * y, 4 * z) for x, y, z in CUBE)),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.type)
def test_rays_meet_each_shape_where_geometry_says(shape: Shape) -> None:
    q, q_BS, p, p_BS = (
        axis_angle((1, -2, 0.5), 0.9),
        axis_angle((0, 1, 1), 0.4),
        np.array([1.0, 2.0, 3.0]),
        np.array([0.1, 0.2, -0.1]),
    )
    placed = PlacedShape(shape=shape, p_BS=tuple(p_BS), q_BS=q_BS)
    target = Body(name="x", motion="static", p_WB=tuple(p), q_WB=q, collision=(placed,))
    R, centre = rotation(multiply(q, q_BS)), p + rotation(q) @ p_BS
    draw = np.random.default_rng(7)
    out = draw.normal(size=(300, 3))
    origins = centre + 3.0 * out / np.linalg.norm(out, axis=1)[:, None]
    if isinstance(shape, Plane):
        origins = origins[(origins - centre) @ R @ np.array(shape.normal) > 0]
    aims = centre + draw.uniform(-0.5, 0.5, (len(origins), 3)) - origins
    directions = aims / np.linalg.norm(aims, axis=1)[:, None]
    hits = ADAPTER.build(Scene(bodies=(free_body("o", (50.0, 0.0, 0.0)), target)), with_options()).cast(
        origins, directions, 10.0
    )
    solid = SHAPES[1] if isinstance(shape, ConvexHull) else shape
    expected = np.array([first_hit(solid, (o - centre) @ R, d @ R) for o, d in zip(origins, directions, strict=True)])
    expected[expected > 10.0] = np.inf
    met = np.isfinite(expected)
    assert met.sum() > 50
    assert (np.isfinite(hits.distance) == met).all()
    assert (hits.body == np.where(met, 1, -1)).all()
    # Rounding over 10 m, grown at grazing rays; a hull's corners are single precision, 2^-24 of 0.4 m, grown alike.
    np.testing.assert_allclose(hits.distance[met], expected[met], atol=1e-6 if isinstance(shape, ConvexHull) else 1e-11)
    assert (np.einsum("ij,ij->i", hits.normal_W, directions)[met] < 0).all()


def test_a_ray_costs_no_more_calls_than_the_vendor_s_own_reading_loop() -> None:
    """The clock runs over `caster`: for each ray the vendor's call and one that keeps what it told."""
    stage, rays = system_rays.scene(system_rays.P()), system_rays.rays(system_rays.P(thin=64))
    simulation = ADAPTER.build(stage, with_options())
    assert isinstance(simulation, DartSimulation)
    args = rays.origins, rays.directions, rays.max_range
    hits, told = simulation.cast(*args), simulation.caster(*args)()
    met = np.array([hit is not None for hit in told])
    assert (met == np.isfinite(hits.distance)).all()
    assert ([hit[0] * rays.max_range for hit in told if hit] == hits.distance[met]).all()
    assert calls_of(simulation.caster(*args)) <= 2 * len(told) + 3


def test_a_run_beyond_double_precision_is_diverged_and_not_repaired() -> None:
    body = Body(name="x", inertia=principal_inertia(1.0, 2.0, 2.5), v_WB=(1e200, 0.0, 0.0), w_WB=(1e200, 1.0, 0.0))
    with pytest.raises(Diverged):
        ADAPTER.build(Scene(bodies=(body,)), with_options()).step()
    with pytest.raises(ValueError, match="finite"):
        ADAPTER.build(Scene(bodies=(free_body("x"),)), with_options()).wrench(np.full((1, 3), np.nan), np.zeros((1, 3)))


def test_the_sign_of_a_quaternion_does_not_jump_while_a_body_turns_round_and_round() -> None:
    q = multiply((-1.0, 0.0, 0.0, 0.0), axis_angle((1.0, 2.0, 3.0), 0.3))
    scene = Scene(bodies=(free_body("x", q_WB=q, w_WB=(0.0, 0.0, 9.0)),), gravity=(0.0, 0.0, 0.0))
    simulation, last = ADAPTER.build(scene, with_options()), np.array(q)
    for _ in range(150):
        simulation.step(10)
        now = state_of(simulation, scene).q_WB[0]
        # Ten steps turn it by 0.09 rad, half of that in the four-dimensional angle.
        assert np.linalg.norm(now - last) < 0.05
        last = now


def test_two_worlds_stepped_in_turn_do_what_one_does_alone() -> None:
    bodies = tuple(
        box_body(f"b{i}", (0.01 * i, 0.0, 0.3 + 0.25 * i), q_WB=axis_angle((1.0, 2.0, 3.0), 0.1 * i)) for i in range(4)
    )
    scene = Scene(bodies=(ground_body(), *bodies), surfaces=(surface_law(), surface_law(between=("b", "b"))))
    for track in (TUNED, DEFAULT):
        settings = with_options(1 / 240, track)
        alone = state_after(scene, 1.0, settings)
        pair = [ADAPTER.build(scene, settings) for _ in range(2)]
        for _ in range(240):
            for one in pair:
                one.step()
        for one in pair:
            assert (state_of(one, scene).p_WB == alone.p_WB).all()
            assert (state_of(one, scene).q_WB == alone.q_WB).all()


def _busy() -> Scene:
    """A little of everything: a fall, sliding, damping, a drive with a limit, a top, a body on its way."""
    bodies = (
        ground_body(),
        box_body("faller", (0.0, 0.0, 0.12), w_WB=(0.3, 0.2, 0.1)),
        box_body("slider", (1.0, 0.0, 0.1), v_WB=(1.0, 0.5, 0.0), linear_damping=0.3, angular_damping=0.2),
        Body(name="belt", motion="kinematic", v_WB=(0.1, 0.0, 0.0), p_WB=(0.0, 0.0, 5.0)),
        free_body("wheel", (0.0, 3.0, 2.0)),
        Body(name="top", inertia=principal_inertia(0.1, 0.1, 0.2), p_WB=(0.0, 5.0, 3.0), w_WB=(0.0, 0.0, 30.0)),
    )
    joints = (
        Revolute(
            name="hinge", parent=WORLD, child="wheel", anchor_W=(0.0, 3.0, 2.0), axis_W=(1.0, 0.0, 0.0),
            drive=replace(PD, limit=3.0),
        ),
        Ball(name="tip", parent=WORLD, child="top", anchor_W=(0.0, 5.0, 2.8)),
    )  # fmt: skip
    return Scene(bodies=bodies, joints=joints, surfaces=(surface_law(), surface_law(between=("b", "b"))))


@pytest.mark.parametrize("drives", ["spring", "stable", "servo"])
def test_sub_steps_are_steps_of_their_own_length_bit_for_bit(drives: str) -> None:
    """With the same forces from outside, four sub-steps of 1/240 s are four steps of 1/960 s: both are the same double."""
    scene = _busy()
    push = np.zeros((6, 3))
    push[1:3] = 0.5, 0.2, 1.0
    whole, fine = (
        ADAPTER.build(scene, replace(with_options(dt, drives=drives), substeps=substeps))
        for dt, substeps in ((1 / 240, 4), (1 / 960, None))
    )
    assert (whole.resolved.dt, whole.resolved.substeps) == (1 / 240, 4)
    assert (fine.resolved.dt, fine.resolved.substeps) == (1 / 960, 1)
    for simulation, count in ((whole, 30), (fine, 120)):
        simulation.step(count)
        simulation.wrench(push, push)
        simulation.step(count)
    for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
        assert (getattr(state_of(whole, scene), name) == getattr(state_of(fine, scene), name)).all()
    assert (whole.contacts().force_W == fine.contacts().force_W).all()


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        (with_options(detector="gjk"), "detector"),
        (replace(TUNED, solver="dantzig", iterations=10), "dantzig"),
        (with_options(error_reduction=1.5), "error_reduction"),
        (with_options(error_reduction=True), "error_reduction"),
        (with_options(joints="links"), "joints"),
        (with_options(ground="box"), "ground"),
    ],
)
def test_settings_that_dart_does_not_have_are_refused(settings: Settings, match: str) -> None:
    with pytest.raises(SettingsError, match=match):
        ADAPTER.build(Scene(bodies=(free_body("x"),)), settings)


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_solver_that_is_asked_for_is_the_one_that_runs(solver: str) -> None:
    iterations = None if solver == "dantzig" else 77
    scene = Scene(bodies=(ground_body(), box_body()), surfaces=(surface_law(),))
    simulation = ADAPTER.build(scene, replace(TUNED, solver=solver, iterations=iterations))
    assert (simulation.resolved.solver, simulation.resolved.iterations) == (solver, iterations)


@pytest.mark.parametrize("solver", ["pgs", "matrix_free"])
def test_a_finer_tolerance_brings_a_swept_solver_nearer_to_the_one_that_pivots(solver: str) -> None:
    """Of at most three hundred sweeps what ends them is the tolerance alone."""
    scene = Scene(
        bodies=(ground_body(), *(box_body(f"b{i}", (0.0, 0.0, 0.1 + 0.2 * i)) for i in range(3))),
        surfaces=(surface_law(), surface_law(between=("b", "b"))),
    )
    exact = state_after(scene, 0.5, replace(with_options(1 / 240), solver="dantzig")).p_WB
    off = []
    for tolerance in (1e-3, 1e-7):
        swept = state_after(scene, 0.5, replace(with_options(1 / 240), solver=solver, iterations=300, tolerance=tolerance))
        off.append(np.abs(swept.p_WB - exact).max())
    assert off[1] < off[0] / 2


def test_building_and_stepping_write_nothing_to_the_console(capfd: pytest.CaptureFixture[str]) -> None:
    scene = Scene(
        bodies=(ground_body(), solid_body("x", ConvexHull(vertices=CUBE), (0.0, 0.0, 0.1))), surfaces=(surface_law(),)
    )
    for solver in ("dantzig", "pgs", "nsgs"):
        ADAPTER.build(scene, replace(TUNED, solver=solver)).step(10)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_no_mesh_file_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    ADAPTER.build(Scene(bodies=(solid_body("x", ConvexHull(vertices=CUBE), (0.0, 0.0, 0.0)),)), with_options()).step()
    assert list(tmp_path.iterdir()) == []
