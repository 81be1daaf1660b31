"""Nuts and bolts in a bowl: solids and bowl by another route, metrics on a heap made by hand, and planted faults."""

import math
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline import engine
from plumbline.adapters.reference import ADAPTER
from plumbline.cases import stack_bowl
from plumbline.cases.stack_bowl import CASE, FLOOR, LEAN, POST, RINGS, SETTLED, THICK, TOP, P, scene
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.conservation import energy_rise_max
from plumbline.harness.metrics.contacts import penetration
from plumbline.harness.metrics.overlaps import unthreaded
from plumbline.harness.scene import EARTH_GRAVITY, Box, TriangleMesh
from plumbline.harness.trajectory import Contacts, Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back
from tests.conformance.put import put
from tests.solid_meshes import mass_properties, volume

G = -EARTH_GRAVITY[2]
TIME = np.arange(round(CASE.duration * 20) + 1) / 20
SOLIDS = {"nut": stack_bowl._nut, "bolt": stack_bowl._bolt}


def lying() -> Trajectory:
    """The nuts alone, flat on each other around the post, as the bowl bears them."""
    stage = scene(P(n=0))
    run = Trajectory.of(TIME, len(stage.bodies))
    run.p_WB[:, 1:, 2] = THICK * (2 * np.arange(RINGS) + 1)
    weight = G * sum(body.mass for body in stage.bodies if body.movable)
    contacts = Contacts.of([0], [1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], [0.0], [[0.0, 0.0, weight]])
    return replace(run, dt=CASE.dt, contacts=(contacts,) * len(TIME))


def verdicts(run: Trajectory, *metrics: str) -> dict[str, bool]:
    stage, found = scene(P(n=0)), dict[str, bool]()
    for check in (one for one in CASE.checks if not metrics or one.metric.name in metrics):
        held = check.passes(check.metric(stage, run.between(check.start, 99.0), None), run.dt, CASE.parameters)
        found[check.metric.name] = held and found.get(check.metric.name, True)
    return found


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_solid_has_the_mass_and_inertia_of_its_skin(kind: str) -> None:
    """Sums over tetrahedra of the mesh, which knows of no pieces; pieces that overlapped would have more volume than it."""
    mass, inertia, pieces = SOLIDS[kind]()
    halves = [placed.shape.half_extents for placed in pieces if isinstance(placed.shape, Box)]
    skin = stack_bowl._skin(pieces)
    mesh = engine.TriangleMesh(skin.vertices, skin.faces)
    edges = Counter((f[k], f[(k + 1) % 3]) for f in skin.faces for k in range(3))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert volume(mesh) == pytest.approx(mass / stack_bowl.DENSITY, rel=1e-9)
    assert volume(mesh) == pytest.approx(sum(8 * math.prod(half) for half in halves), rel=1e-9)
    centre, moments = mass_properties(mesh, mass)
    np.testing.assert_allclose(centre, 0.0, atol=1e-9)
    np.testing.assert_allclose(inertia, moments, rtol=1e-9, atol=1e-12)


def _within(points: Floats) -> Floats:
    """In how many boxes of the bowl each point (n, 3) lies."""
    found = np.zeros(len(points))
    for placed in scene(P(n=0)).bodies[0].collision:
        assert isinstance(placed.shape, Box)
        local = rotate_back(np.array(placed.q_BS), points - np.array(placed.p_BS))
        found += (np.abs(local) < np.array(placed.shape.half_extents)).all(axis=1)
    return found


def test_the_bowl_is_closed_and_nothing_sticks_out_into_it() -> None:
    """A point above the floor and inside all eight walls is free but for the post; a hair below one of them it is in steel."""
    drawn = np.random.default_rng(0).uniform((-0.45, -0.45, 0.0), (0.45, 0.45, 0.24), (20_000, 3))
    azimuth = np.arange(8) * math.pi / 4
    inward = np.stack([-np.sin(LEAN) * np.cos(azimuth), -np.sin(LEAN) * np.sin(azimuth), np.full(8, np.cos(LEAN))], axis=1)
    over = (drawn[:, None] - FLOOR * np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(8)], axis=1)) * inward
    depth = over.sum(axis=2).min(axis=1)
    post = (np.abs(drawn[:, :2]) < POST).all(axis=1) & (drawn[:, 2] < TOP)
    assert not _within(drawn[(depth > 1e-9) & ~post]).any()
    assert _within(drawn[post]).all()
    assert _within(drawn[(depth < -1e-9) & (depth > -0.01)]).all()
    floor = drawn[np.hypot(drawn[:, 0], drawn[:, 1]) < FLOOR] * (1.0, 1.0, 0.0) - (0.0, 0.0, 1e-6)
    assert _within(floor).all()


@pytest.mark.parametrize("parameters", [{}, {"seed": 5}, {"n": 9, "seed": 1}])
def test_bodies_start_apart_and_the_nuts_around_the_post(parameters: dict[str, Any]) -> None:
    stage = scene(P(**parameters))
    start = Trajectory.of(np.zeros(1), len(stage.bodies))
    start.p_WB[:], start.q_WB[:] = [b.p_WB for b in stage.bodies], [b.q_WB for b in stage.bodies]
    assert penetration(stage, start, None) == 0.0
    assert unthreaded(stage, start, None) == 0.0


def test_a_mesh_is_the_same_body_and_another_form_is_refused() -> None:
    for pieces, mesh in zip(scene(P()).bodies[1:], scene(P(form="mesh")).bodies[1:], strict=True):
        assert [type(placed.shape) for placed in mesh.collision] == [TriangleMesh]
        assert replace(mesh, collision=pieces.collision) == pieces
    with pytest.raises(ValueError, match="form 'hull', expected pieces or mesh"):
        scene(P(form="hull"))


def test_nuts_that_lie_on_each_other_around_the_post_pass() -> None:
    assert all(verdicts(lying()).values())


def test_a_ring_that_comes_off_sideways_is_seen_and_one_that_lies_askew_is_not() -> None:
    """Its centre leaves the post at half its width, long after steel stands in steel; within the clearance it is free."""
    run = lying()
    run.p_WB[50:, 2, 0] = 0.004
    assert verdicts(run, "unthreaded")["unthreaded"]
    run.p_WB[50:, 2, 0] = POST + 0.01
    found = verdicts(run, "unthreaded", "penetration")
    assert not found["unthreaded"]
    assert unthreaded(scene(P(n=0)), run, None) == pytest.approx(0.01)
    assert not found["penetration"]


def test_a_ring_over_the_top_is_off_as_well() -> None:
    run = lying()
    run.p_WB[50:, 2, 2] = TOP + 0.05
    assert unthreaded(scene(P(n=0)), run, None) == pytest.approx(0.05)


def test_where_nothing_is_threaded_there_is_nothing_to_measure() -> None:
    stage = scene(P(n=4))
    loose = replace(stage, bodies=(stage.bodies[0], *stage.bodies[1 + RINGS :]))
    with pytest.raises(NotMeasurable, match="no body is put over a box of another"):
        unthreaded(loose, Trajectory.of(TIME, len(loose.bodies)), None)


def test_energy_that_comes_back_is_seen_and_energy_that_goes_is_not() -> None:
    """Two nuts of one mass: one of them higher by h again has g h/2 a kilogram more than there was."""
    run = lying()
    run.p_WB[:20, 2, 2] += 0.1
    assert energy_rise_max(scene(P(n=0)), run, None) == 0.0
    run.p_WB[200:, 2, 2] += 0.05
    assert energy_rise_max(scene(P(n=0)), run, None) == pytest.approx(G * 0.05 / 2)
    assert not verdicts(run, "energy_rise_max")["energy_rise_max"]


@pytest.mark.parametrize("metric", [unthreaded, energy_rise_max])
def test_a_number_that_is_not_finite_is_not_swallowed(metric: Any) -> None:
    run = lying()
    run.p_WB[50, 1, 2] = math.nan
    assert math.isnan(metric(scene(P(n=0)), run, None))


def test_each_fault_at_rest_fails_its_own_check() -> None:
    late = round(20 * SETTLED) + 20
    buzzing = lying()
    buzzing.v_WB[late:, 2, 2] = 0.2 * (-1.0) ** np.arange(len(TIME) - late)
    assert not verdicts(buzzing, "rms_speed")["rms_speed"]
    spinning = lying()
    spinning.w_WB[late:, 2, 2] = 2.0
    assert not verdicts(spinning, "rms_spin")["rms_spin"]
    creeping = lying()
    creeping.p_WB[:, 2, 0] = 5e-4 * TIME
    creeping.p_WB[:, 2, 1] = -8e-4 * TIME
    assert not verdicts(creeping, "rest_drift")["rest_drift"]
    sunk = lying()
    sunk.p_WB[late:, 1:, 2] -= 2e-3
    assert not verdicts(sunk, "penetration")["penetration"]
    light = lying()
    assert light.contacts is not None
    light = replace(light, contacts=(light.contacts[0],) * late + (Contacts.none(),) * (len(TIME) - late))
    assert not verdicts(light, "support_force_error")["support_force_error"]


def test_an_engine_that_takes_a_nut_for_its_hull_throws_it_off_the_post() -> None:
    """The reference engine at its own coarser level of detail; as meshes nuts stay."""
    short = replace(CASE, duration=1.0, checks=tuple(c for c in CASE.checks if not c.start), observe=())
    settings = ADAPTER.tracks["default"].with_dt(CASE.dt)
    for level, off in (("mesh", False), ("hull", True)):
        asked = replace(settings, options={**settings.options, "level_of_detail": level})
        answer = put(short, ADAPTER, asked, parameters={"n": 0, "form": "mesh"})
        assert ("unthreaded" in answer.broken) is off


@pytest.mark.slow
@pytest.mark.parametrize("dt", [1 / 120, 1 / 240])
def test_bodies_of_one_mesh_each_come_to_rest_and_stay_on_the_post(dt: float) -> None:
    answer = put(CASE, ADAPTER, ADAPTER.tracks["tuned"].with_dt(dt), parameters={"form": "mesh"})
    assert answer.broke is None
    assert answer.broken == {}
