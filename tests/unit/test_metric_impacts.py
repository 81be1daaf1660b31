"""Rows, containment, inscribed overlap, energy won and passage: a clean answer is not flagged, a planted fault is seen."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.metrics.conservation import energy_gain_max, energy_growth_rate
from plumbline.harness.metrics.impacts import last_share_error, touching_last_share
from plumbline.harness.metrics.overlaps import escaped_share, inscribed_overlap
from plumbline.harness.metrics.passage import (
    lateral_kick,
    passage_probability,
    passage_probability_high,
    passage_probability_low,
    rest_speed,
    sink_depth,
)
from plumbline.harness.scene import Body, Box, Capsule, PlacedShape, Plane, Scene, Sphere, Surface, axis_angle
from plumbline.harness.statistics.student import wilson_interval
from plumbline.harness.trajectory import Trajectory

TIME = np.linspace(0.0, 1.0, 11)


def ball(name: str, x: float, v: float = 0.0, radius: float = 0.1, material: str = "default") -> Body:
    shape = (PlacedShape(shape=Sphere(radius=radius)),)
    return Body(name=name, material=material, collision=shape, p_WB=(x, 0.0, 0.0), v_WB=(v, 0.0, 0.0))


def still(scene: Scene) -> Trajectory:
    """Every body in its initial state throughout."""
    run = Trajectory.of(TIME, len(scene.bodies))
    run.p_WB[:] = [b.p_WB for b in scene.bodies]
    run.q_WB[:] = [b.q_WB for b in scene.bodies]
    run.v_WB[:] = [b.v_WB for b in scene.bodies]
    run.w_WB[:] = [b.w_WB for b in scene.bodies]
    return run


# --- rows -----------------------------------------------------------------------------------------


def row(gap: float, along: float = 1.0) -> Scene:
    """Three balls, the first of which moves; `along` -1 turns the row round."""
    places = (-0.5, 0.0, 0.2 + gap)
    balls = tuple(ball(f"b{i}", along * x, along * 2.0 * (i == 0)) for i, x in enumerate(places))
    return Scene(bodies=balls[::-1], surfaces=(Surface(restitution=1.0),), gravity=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("along", [1.0, -1.0])
def test_the_last_ball_is_the_one_at_the_other_end_of_the_row(along: float) -> None:
    scene = row(0.01, along)
    run = still(scene)
    run.v_WB[-1] = 0.0
    run.v_WB[-1, 0, 0] = along * 2.0
    assert last_share_error(scene, run) == pytest.approx(0.0, abs=1e-15)
    run.v_WB[-1, 0, 0] = along * 1.9
    assert last_share_error(scene, run) == pytest.approx(0.05)
    run.v_WB[-1, 0], run.v_WB[-1, 1] = run.v_WB[-1, 1].copy(), run.v_WB[-1, 0].copy()
    assert last_share_error(scene, run) == pytest.approx(1.0)


def test_a_touching_row_has_a_share_and_no_error() -> None:
    scene = row(0.0)
    run = still(scene)
    run.v_WB[-1, 0, 0] = 0.8
    assert touching_last_share(scene, run) == pytest.approx(0.4)
    with pytest.raises(NotMeasurable, match="every row touches"):
        last_share_error(scene, run)
    with pytest.raises(NotMeasurable, match="no row touches"):
        touching_last_share(row(0.01), still(row(0.01)))
    with pytest.raises(NotMeasurable, match="no row of balls"):
        last_share_error(Scene(bodies=(ball("alone", 0.0, 1.0),)), still(Scene(bodies=(ball("alone", 0.0, 1.0),))))


# --- containment ----------------------------------------------------------------------------------


def hollow() -> Scene:
    """A cube of walls, inner half edge 1 and outer 1.2, and four balls in it."""
    walls = []
    for axis in range(3):
        for side in (-1.1, 1.1):
            half, place = [1.2] * 3, [0.0] * 3
            half[axis], place[axis] = 0.1, side
            box = Box(half_extents=(half[0], half[1], half[2]))
            walls.append(PlacedShape(shape=box, p_BS=(place[0], place[1], place[2])))
    cube = Body(name="cube", material="wall", collision=tuple(walls))
    balls = tuple(ball(f"b{i}", 0.3 * i, material="ball") for i in range(4))
    return Scene(bodies=(*balls, cube), surfaces=(Surface(between=("ball", "wall")), Surface(between=("ball", "ball"))))


def test_a_ball_has_escaped_when_it_is_beyond_the_walls_wherever_the_box_is_and_however_it_turned() -> None:
    scene = hollow()
    run = still(scene)
    turn = axis_angle((0.0, 0.0, 1.0), np.pi / 4)
    run.q_WB[-1, 4] = turn
    run.p_WB[-1, :, 2] += 7.0
    run.p_WB[-1, 0, :2] = (1.6, 0.0)  # in the corner of the turned cube, sqrt(2) 1.2 = 1.697 away
    assert escaped_share(scene, run) == 0.0
    run.p_WB[-1, 0, :2] = (1.1, 1.1)  # 1.56 along a turned axis
    assert escaped_share(scene, run) == 0.25
    with pytest.raises(NotMeasurable, match="no container"):
        escaped_share(row(0.01), still(row(0.01)))


# --- inscribed overlap ----------------------------------------------------------------------------


def test_only_bodies_that_can_touch_and_do_overlap_count() -> None:
    box = Body(name="box", collision=(PlacedShape(shape=Box(half_extents=(0.5, 0.2, 0.3))),), p_WB=(1.0, 0.0, 0.0))
    ghost = ball("ghost", 1.0, material="ghost")
    scene = Scene(
        bodies=(ball("ball", 0.0), box, ghost),
        surfaces=(Surface(),),
        apart=(("ghost", "default"),),
    )
    run = still(scene)
    assert inscribed_overlap(scene, run) == 0.0
    run.p_WB[4, 0, 0] = 0.75
    assert inscribed_overlap(scene, run) == pytest.approx(0.05)
    with pytest.raises(NotMeasurable, match="no two bodies"):
        inscribed_overlap(Scene(bodies=(ball("a", 0.0),)), still(Scene(bodies=(ball("a", 0.0),))))


# --- energy ---------------------------------------------------------------------------------------


def test_energy_won_is_seen_and_energy_lost_is_no_gain() -> None:
    scene = Scene(bodies=(ball("b", 0.0, 2.0),), gravity=(0.0, 0.0, 0.0))
    run = still(scene)
    assert energy_gain_max(scene, run) == 0.0
    assert energy_growth_rate(scene, run) == 0.0
    run.v_WB[:, 0, 0] = 2.0 * np.sqrt(1 - 0.3 * TIME)
    assert energy_gain_max(scene, run) == 0.0
    assert energy_growth_rate(scene, run) == pytest.approx(0.3)
    run.v_WB[:, 0, 0] = 2.0 * np.sqrt(1 + 0.1 * TIME)
    assert energy_gain_max(scene, run) == pytest.approx(0.1)
    assert energy_growth_rate(scene, run) == pytest.approx(0.1)
    with pytest.raises(NotMeasurable, match="2 samples"):
        energy_growth_rate(scene, run.between(0.0, 0.1))


# --- passage --------------------------------------------------------------------------------------


def wall(v: tuple[float, float, float] = (5.0, 1.0, 0.0), count: int = 4) -> Scene:
    """Balls of radius 0.1 shot slantwise at a wall 4 cm thick whose face is x = 0."""
    shape = (PlacedShape(shape=Sphere(radius=0.1)),)
    balls = tuple(
        Body(name=f"b{i}", material="ball", collision=shape, p_WB=(-1.0, float(i), 0.0), v_WB=v) for i in range(count)
    )
    slab = (PlacedShape(shape=Box(half_extents=(0.02, 20.0, 1.0))),)
    fixed = Body(name="wall", motion="static", material="wall", collision=slab, p_WB=(0.02, 0.0, 0.0))
    return Scene(
        bodies=(fixed, *balls),
        surfaces=(Surface(between=("ball", "wall")),),
        gravity=(0.0, 0.0, 0.0),
        apart=(("ball", "ball"),),
    )


def stopped(scene: Scene) -> Trajectory:
    """The truth: at the face from half time on, sliding along it."""
    truth = still(scene)
    for place, body in enumerate(scene.bodies[1:], start=1):
        truth.p_WB[:, place, 0] = np.minimum(-1.0 + body.v_WB[0] * TIME, -0.1)
        truth.p_WB[:, place, 1] += body.v_WB[1] * TIME
        truth.v_WB[TIME > 0.18, place, 0] = 0.0
    return truth


def test_the_truth_passes_nothing_is_kicked_and_rests() -> None:
    scene = wall()
    truth = stopped(scene)
    assert [m(scene, truth, truth) for m in (passage_probability, lateral_kick, rest_speed)] == [0.0, 0.0, 0.0]
    bounds = [m(scene, truth, truth) for m in (passage_probability_low, passage_probability_high)]
    assert tuple(bounds) == wilson_interval(0, 4)


@pytest.mark.parametrize(
    ("deeper", "share", "sunk"),
    # From its place at the face a centre is 0.1 m before it, and 0.12 m before the middle of the wall.
    [(-3.0, 0.0, 0.0), (0.021, 0.0, 0.21), (0.119, 0.0, 1.19), (0.121, 0.25, 0.0), (0.3, 0.25, 0.0), (9.0, 0.25, 0.0)],
)
def test_a_centre_beyond_the_middle_has_passed_and_what_stays_before_it_has_sunk(
    deeper: float, share: float, sunk: float
) -> None:
    scene = wall()
    truth, run = stopped(scene), stopped(scene)
    run.p_WB[-1, 2, 0] += deeper
    assert passage_probability(scene, run, truth) == share
    assert sink_depth(scene, run, truth) == pytest.approx(sunk)


def test_a_ball_has_passed_a_half_space_when_its_centre_is_below_the_surface() -> None:
    scene = wall(v=(0.0, 0.0, -5.0), count=1)
    floor = Body(name="wall", motion="static", material="wall", collision=(PlacedShape(shape=Plane()),))
    fallen = replace(scene.bodies[1], p_WB=(0.0, 0.0, 1.0))
    scene = replace(scene, bodies=(floor, fallen))
    truth = still(scene)
    truth.p_WB[-1, 1, 2], truth.v_WB[-1] = 0.1, 0.0
    for height, share in ((0.001, 0.0), (-0.001, 1.0)):
        run = replace(truth, p_WB=truth.p_WB.copy())
        run.p_WB[-1, 1, 2] = height
        assert passage_probability(scene, run, truth) == share


def test_way_along_the_wall_is_no_passage_and_velocity_splits_into_kick_and_rest() -> None:
    scene = wall()
    truth, run = stopped(scene), stopped(scene)
    run.p_WB[-1, 1, 1] += 3.0
    run.v_WB[-1, 1] += (0.2, 0.3, 0.4)
    assert passage_probability(scene, run, truth) == 0.0
    assert lateral_kick(scene, run, truth) == pytest.approx(0.5)
    assert rest_speed(scene, run, truth) == pytest.approx(0.2)
    run.p_WB[-1, 1, 0] += 1.0
    # What has passed is no longer asked how it rests.
    assert lateral_kick(scene, run, truth) == 0.0
    run.p_WB[-1, 1:, 0] += 1.0
    with pytest.raises(NotMeasurable, match="no body is stopped"):
        rest_speed(scene, run, truth)


def test_two_bodies_that_both_move_have_passed_when_their_centres_have_changed_sides() -> None:
    scene = Scene(bodies=(ball("left", -1.0, 5.0), ball("right", 1.0, -5.0)), surfaces=(Surface(),), gravity=(0.0, 0.0, 0.0))
    truth = still(scene)
    truth.p_WB[-1, :, 0], truth.v_WB[-1] = (-0.1, 0.1), 0.0
    run = replace(truth, p_WB=truth.p_WB.copy())
    run.p_WB[-1, :, 0] = (-0.001, 0.001)
    assert passage_probability(scene, run, truth) == 0.0
    assert sink_depth(scene, run, truth) == pytest.approx(0.99)
    # Both far to one side, in their order: pushed on, not passed.
    run.p_WB[-1, :, 0] = (0.5, 0.7)
    assert passage_probability(scene, run, truth) == 0.0
    run.p_WB[-1, :, 0] = (0.001, -0.001)
    assert passage_probability(scene, run, truth) == 1.0


@pytest.mark.parametrize(("turned", "share"), [(0.5, 0.0), (0.529, 0.0), (0.531, 1.0), (0.5 + np.pi, 1.0), (-3.0, 0.0)])
def test_a_rod_is_judged_by_the_way_of_its_posts_through_more_than_a_turn(turned: float, share: float) -> None:
    rod = Body(
        name="rod",
        material="rod",
        collision=(PlacedShape(shape=Capsule(radius=0.01, half_length=1.2)),),
        q_WB=axis_angle((0.0, 1.0, 0.0), np.pi / 2),
        w_WB=(0.0, 0.0, 4.0),
    )
    post = Body(
        name="post",
        motion="static",
        material="post",
        collision=(PlacedShape(shape=Sphere(radius=0.02)),),
        p_WB=(np.cos(0.5), np.sin(0.5), 0.0),
    )
    scene = Scene(bodies=(rod, post), surfaces=(Surface(between=("rod", "post")),), gravity=(0.0, 0.0, 0.0))

    def turning(angle: float) -> Trajectory:
        run = still(scene)
        for k, part in enumerate(np.linspace(0.0, angle, len(TIME))):
            from plumbline.harness.scene import multiply

            run.q_WB[k, 0] = multiply(axis_angle((0.0, 0.0, 1.0), float(part)), rod.q_WB)
        run.w_WB[-1] = 0.0
        return run

    assert passage_probability(scene, turning(turned), turning(0.5)) == share


def test_a_truth_that_stops_nothing_is_not_measurable() -> None:
    scene = wall()
    truth = still(scene)
    with pytest.raises(NotMeasurable, match="stops no body"):
        passage_probability(scene, truth, truth)
    with pytest.raises(NotMeasurable, match="no truth"):
        passage_probability(scene, truth, None)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(
    "metric",
    [
        passage_probability,
        passage_probability_low,
        passage_probability_high,
        lateral_kick,
        rest_speed,
        sink_depth,
        inscribed_overlap,
        energy_gain_max,
        energy_growth_rate,
    ],
)
def test_what_is_not_finite_is_never_swallowed(metric: Metric, bad: float) -> None:
    scene = wall()
    if metric is inscribed_overlap:
        scene = row(0.01)
    truth = stopped(scene) if metric is not inscribed_overlap else still(scene)
    run = still(scene)
    run.p_WB[5, 1] = bad
    run.v_WB[5, 1] = bad
    with np.errstate(invalid="ignore"):
        assert not np.isfinite(metric(scene, run, truth))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_rows_and_containers_do_not_swallow_it_either(bad: float) -> None:
    for scene, metric in ((row(0.01), last_share_error), (row(0.0), touching_last_share), (hollow(), escaped_share)):
        run = still(scene)
        run.p_WB[5, 1, 0] = bad
        assert np.isnan(metric(scene, run))
