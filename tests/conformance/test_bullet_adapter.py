"""What is particular to Bullet: its two kinds of coordinates, turned inertia, rays, pictures, settings."""

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Diverged, Settings, SettingsError
from plumbline.harness.conformance.closed_forms import turning
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Camera,
    Effect,
    PlacedShape,
    Plane,
    Scene,
    axis_angle,
    multiply,
)

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")
from tests.conformance.bullet_scenes import (
    COORDINATES,
    DEFAULT,
    GROUND,
    NOWHERE,
    TUNED,
    TURNED,
    G,
    ball,
    built,
    law,
    state_of,
    tensor,
    with_options,
)


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


@pytest.mark.parametrize("track", ["default", "tuned"])
def test_damping_is_exponential_whatever_the_step(track: str) -> None:
    body = Body(name="body", linear_damping=2.0, angular_damping=3.0, v_WB=(3.0, 0.0, 0.0), w_WB=(0.0, 0.0, 3.0))
    scene = Scene(bodies=(body,), gravity=NOWHERE)
    with built(scene, ADAPTER.tracks[track].with_dt(0.05)) as simulation:
        simulation.step(10)
        got = state_of(simulation, scene)
    assert got.v_WB[0, 0] == pytest.approx(3 * math.exp(-1.0), rel=1e-12)
    assert got.w_WB[0, 2] == pytest.approx(3 * math.exp(-1.5), rel=1e-12)


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
    monkeypatch.setattr("plumbline.adapters.bullet.simulation.check_wrench", lambda *_: None)
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
        "from plumbline.adapters.bullet import ADAPTER; from plumbline.harness.scene import Body, Scene;"
        "s = ADAPTER.build(Scene(bodies=(Body(name='a'),)), ADAPTER.tracks['tuned']); s.step(); s.close()"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert (run.stdout, run.stderr) == (b"", b"")
