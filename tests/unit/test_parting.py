"""How far two motions lie apart, as a share of the size of what moves: by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.scene import Ball, Body, Scene, axis_angle, box_inertia, sphere_inertia
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.parting import apart, common, displaced, extent, length, offsets


def two() -> Scene:
    """A rod of a metre on a joint at its end, and a pebble of 2 cm far away."""
    rod = Body(name="rod", inertia=box_inertia(1.0, (0.5, 1e-3, 1e-3)), p_WB=(0.5, 0, 0))
    pebble = Body(name="pebble", mass=0.01, inertia=sphere_inertia(0.01, 0.01), p_WB=(20, 0, 0))
    return Scene(bodies=(rod, pebble), joints=(Ball(name="j", parent="world", child="rod", anchor_W=(0, 0, 0)),))


def still(scene: Scene, samples: int = 3) -> Trajectory:
    run = Trajectory.of(np.arange(samples) / 60, len(scene.bodies))
    run.p_WB[:] = [body.p_WB for body in scene.bodies]
    return run


def test_each_whole_has_a_size_of_its_own() -> None:
    """The rod's centre is half a metre from its anchor, its radius of gyration 1/sqrt(12) m; the pebble's is sqrt(.4) cm."""
    scale = extent(two())
    r = 1 / math.sqrt(12)
    assert scale.size[0] == pytest.approx(math.hypot(0.5 + r, 2 * r, 2 * r), rel=1e-4)
    assert scale.size[1] == pytest.approx(2 * math.sqrt(3 * 0.4) * 0.01)
    assert scale.largest == scale.size[0]


def test_bodies_that_joints_hold_together_are_one_whole_and_the_world_joins_nobody() -> None:
    bodies = tuple(
        Body(name=name, inertia=sphere_inertia(1.0, 0.1), p_WB=(x, 0, 0)) for name, x in (("a", 0), ("b", 1), ("c", 9))
    )
    joints = (
        Ball(name="ab", parent="a", child="b", anchor_W=(0.5, 0, 0)),
        Ball(name="wa", parent="world", child="a", anchor_W=(0, 0, 0)),
        Ball(name="wc", parent="world", child="c", anchor_W=(9, 0, 0)),
    )
    scale = extent(Scene(bodies=bodies, joints=joints))
    assert scale.size[0] == scale.size[1] > 1.0
    assert scale.size[2] < 0.3


def test_a_way_and_a_turn_add_up_and_the_worst_body_counts() -> None:
    scene, scale = two(), extent(two())
    base, run = still(scene), still(scene)
    run.p_WB[1, 0] += (0.003, 0.004, 0.0)
    run.q_WB[1, 0] = axis_angle((0, 0, 1), 0.01)
    run.p_WB[2, 1] += (0.0, 0.0, 0.001)
    way = apart(run, base, scale)
    assert way[0] == 0.0
    assert way[1] == pytest.approx((0.005 + 0.01 * scale.gyration[0]) / scale.size[0])
    # A millimetre is nothing for the rod and a lot for a pebble of two centimetres.
    assert way[2] == pytest.approx(0.001 / scale.size[1])


def test_a_quaternion_and_its_negative_are_one_attitude() -> None:
    scene = two()
    run = still(scene)
    run.q_WB[:] *= -1.0
    assert not apart(run, still(scene), extent(scene)).any()


def test_a_run_moved_by_its_offsets_is_the_run_again() -> None:
    scene, scale = two(), extent(two())
    base, run = still(scene), still(scene)
    rng = np.random.default_rng(1)
    run.p_WB[:] += rng.normal(size=run.p_WB.shape)
    for k in range(3):
        base.q_WB[k, 0] = axis_angle(tuple(rng.normal(size=3)), 0.4)
        run.q_WB[k, 0] = axis_angle(tuple(rng.normal(size=3)), rng.uniform(0, 3))
    again = displaced(base, offsets(run, base, scale), scale)
    assert length(offsets(again, run, scale)).max() < 1e-14


def test_runs_are_compared_at_the_samples_that_all_have() -> None:
    scene = two()
    long, short = still(scene, 5), still(scene, 3)
    here, there = common([long, short])
    assert here.time.tolist() == there.time.tolist() == short.time.tolist()
