"""The truth of stack_arch: its least thickness by limit analysis against the literature, its geometry, its checks."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plumbline.adapters.reference import ADAPTER
from plumbline.cases.stack_arch import CASE, DENSITY, DEPTH, FRICTION, THICKNESS, P, expected, scene, voussoir
from plumbline.harness.scene import ConvexHull, Scene, rotate
from plumbline.harness.trajectory import Contacts, Floats, State, Trajectory
from tests.limit_analysis import GROUND, Point, stands

NO_SLIDING = 10.0


def corners(stage: Scene) -> Floats:
    """Of each block in W, (blocks, 4, 2) m: inner and outer of the joint before it, then of the one after."""
    found = []
    for body in stage.bodies[1:]:
        hull = body.collision[0].shape
        assert isinstance(hull, ConvexHull)
        front = [v for v in hull.vertices if v[1] > 0]
        placed = [np.array(body.p_WB) + np.array(rotate(body.q_WB, v)) for v in front]
        order = sorted(range(4), key=lambda k: (front[k][0] > 0, front[k][2]))
        found.append([(placed[k][0], placed[k][2]) for k in order])
    return np.array(found)


def arch_stands(thickness: float, blocks: int, friction: float) -> bool:
    stage = scene(P(thickness, blocks, friction))
    places, bodies = corners(stage), stage.bodies[1:]
    points = []
    for i in range(blocks + 1):
        # The joint before block i, at the angle pi i/n from the springing at -x; its normal is tangential to the ring.
        angle = math.pi * i / blocks
        normal = (math.sin(angle), math.cos(angle))
        a, b = (i - 1 if i else GROUND), (i if i < blocks else GROUND)
        ends = places[i, :2] if i < blocks else places[i - 1, 2:]
        points += [Point(a, b, (float(x), float(z)), normal, friction) for x, z in ends]
    return stands([(b.p_WB[0], b.p_WB[2]) for b in bodies], [b.mass for b in bodies], points)


@cache
def least_thickness(blocks: int) -> float:
    low, high = 0.05, 0.2
    while high - low > 1e-5:
        middle = (low + high) / 2
        low, high = (low, middle) if arch_stands(middle, blocks, NO_SLIDING) else (middle, high)
    return (low + high) / 2


def test_the_least_thickness_of_a_fine_arch_is_that_of_milankovitch() -> None:
    # 0.1075 to its last digit; joints at pi/121 instead of everywhere leave less than that digit.
    assert not arch_stands(0.1074, 121, NO_SLIDING)
    assert arch_stands(0.1076, 121, NO_SLIDING)


def test_few_blocks_need_less_and_the_case_is_twice_as_thick_as_its_own_need() -> None:
    least = least_thickness(9)
    assert least == pytest.approx(0.1015, abs=1e-4)
    assert 1.9 < THICKNESS / least < 2.1


@pytest.mark.parametrize(("share", "standing"), [(0.95, False), (1.05, True)])
def test_a_simulated_arch_falls_just_below_the_least_thickness_and_stands_just_above(share: float, standing: bool) -> None:
    # Compliance of the contacts eats into the ring: 4e-5 of its height at 240 Hz, far less than these 5 %.
    stage, settings = scene(P(share * least_thickness(9))), ADAPTER.tracks["tuned"].with_dt(1 / 240)
    simulation = ADAPTER.build(stage, settings)
    simulation.step(480)
    end = State.initial(stage)
    simulation.state(end)
    crown = 5
    assert (end.p_WB[crown, 2] > 0.99 * stage.bodies[crown].p_WB[2]) == standing


def test_friction_holds_the_joints_of_the_case_and_little_friction_would_not() -> None:
    assert arch_stands(THICKNESS, 9, FRICTION)
    assert arch_stands(THICKNESS, 9, 0.4)
    assert not arch_stands(THICKNESS, 9, 0.3)


@pytest.mark.parametrize(("thickness", "blocks"), [(0.2, 9), (0.12, 15), (0.3, 4)])
def test_blocks_touch_face_to_face_stand_on_the_ground_and_have_the_mass_of_the_ring(thickness: float, blocks: int) -> None:
    stage = scene(P(thickness, blocks))
    places = corners(stage)
    np.testing.assert_allclose(places[1:, :2], places[:-1, 2:], atol=1e-14)
    np.testing.assert_allclose([places[0, :2, 1], places[-1, 2:, 1]], 0.0, atol=1e-14)
    # Chords cut sin(x)/x off the area of the ring, x the angle of a block.
    block = math.pi / blocks
    ring = math.pi * thickness * math.sin(block) / block
    assert sum(b.mass for b in stage.bodies[1:]) == pytest.approx(DENSITY * DEPTH * ring)


def test_the_inertia_of_a_block_is_that_of_a_cloud_of_points() -> None:
    outline, _ = voussoir(THICKNESS, 9)
    body = scene(P()).bodies[1]
    rng = np.random.default_rng(1)
    span = np.abs(outline).max(axis=0)
    cloud = rng.uniform(-span, span, (2_000_000, 2))
    (a, low), (b, high) = outline[1], outline[2]
    inside = cloud[(cloud[:, 1] > low) & (np.abs(cloud[:, 0]) < a + (b - a) * (cloud[:, 1] - low) / (high - low))]
    inside = inside[inside[:, 1] < high]
    # A million points: means of squares to a few thousandths, the centroid to as much of the width.
    np.testing.assert_allclose(inside.mean(axis=0), 0.0, atol=3e-3 * span.max())
    xx, zz = (inside**2).mean(axis=0)
    yy = DEPTH**2 / 12
    np.testing.assert_allclose(np.diag(body.inertia) / body.mass, (yy + zz, xx + zz, xx + yy), rtol=5e-3)


def rest(dt: float = 1 / 240) -> Trajectory:
    """The truth at 60 Hz with the weight on both springings."""
    time = np.arange(121) / 60
    weight = 9.81 * sum(b.mass for b in scene(P()).bodies[1:])
    contacts = Contacts.of(
        [0, 0], [1, 9], [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]] * 2, [0.0] * 2, [[0.0, 0.0, weight / 2]] * 2
    )
    return replace(expected(time, P()), dt=dt, contacts=(contacts,) * len(time))


def verdicts(run: Trajectory) -> dict[str, bool]:
    return {
        c.metric.name: c.passes(
            c.metric(scene(P()), run.between(c.start, 99.0), expected(run.time, P())), run.dt, CASE.parameters
        )
        for c in CASE.checks
    }


@pytest.mark.parametrize("dt", CASE.ladder)
def test_the_truth_passes_every_check(dt: float) -> None:
    assert all(verdicts(rest(dt)).values())


def test_an_arch_whose_crown_falls_fails_as_collapsed() -> None:
    run = rest()
    run.p_WB[100:, 5, 2] = 0.1
    assert not verdicts(run)["collapse_time"]


def test_a_support_too_few_and_blocks_that_sway_fail() -> None:
    run = rest()
    assert run.contacts is not None
    lame = replace(run.contacts[0], force_W=run.contacts[0].force_W * np.array([[1.0], [0.9]]))
    assert not verdicts(replace(run, contacts=(lame,) * len(run)))["support_force_error"]
    run.v_WB[:, 4, 0] = 0.1
    assert not verdicts(run)["rms_speed"]
