"""The truths of the stacks that only have to stand: their geometry and statics by hand, and planted faults that fail."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from plumbline.cases import stack_heavy_on_two, stack_mass_ratio, stack_overlap_recovery, stack_pyramid
from plumbline.harness.case import Case
from plumbline.harness.scene import Body, Box, Plane, Scene, Sphere, rotate
from plumbline.harness.trajectory import Contacts, Floats, Trajectory

G = 9.81
CASES = [m.CASE for m in (stack_mass_ratio, stack_heavy_on_two, stack_pyramid, stack_overlap_recovery)]


def at_rest(case: Case, dt: float = 1 / 240, **parameters: Any) -> Trajectory:
    """The truth at 60 Hz, with each weight on the ground, and on the heaviest body's supports in equal parts."""
    chosen = dict(case.parameters) | parameters
    time = np.arange(round(case.duration * 60) + 1) / 60
    stage, truth = case.scene(case.at(**chosen)), case.truth_at(time, chosen)
    assert isinstance(truth, Trajectory)
    places = [place for place, body in enumerate(stage.bodies) if body.movable]
    heavy = max(places, key=lambda place: stage.bodies[place].mass)
    supports = [place for place in places if place != heavy]
    share = stage.bodies[heavy].mass * G / len(supports)
    forces = [(0, place, stage.bodies[place].mass * G + share) for place in supports]
    forces += [(place, heavy, share) for place in supports]
    contacts = Contacts.of(
        [a for a, _, _ in forces],
        [b for _, b, _ in forces],
        [[0.0] * 3] * len(forces),
        [[0.0, 0.0, 1.0 if a < b else -1.0] for a, b, _ in forces],
        [0.0] * len(forces),
        [[0.0, 0.0, f] for _, _, f in forces],
    )
    # The other starts of a case that tells them end like the first.
    names = [] if case.retellings is None else [told.name for told in case.retellings(case.at(**chosen))]
    streams = {f"{name}/{stream}": array for name in names for stream, array in (("time", time), ("v_WB", truth.v_WB))}
    return replace(truth, dt=dt, contacts=(contacts,) * len(time), streams=streams)


def verdicts(case: Case, run: Trajectory) -> dict[str, bool]:
    chosen = dict(case.parameters)
    truth = case.truth_at(run.time, chosen)
    assert isinstance(truth, Trajectory)
    stage = case.scene(case.at(**chosen))
    return {
        c.metric.name: c.passes(
            c.metric(stage, run.between(c.start, 99.0), truth.between(c.start, 99.0)), run.dt, case.parameters
        )
        for c in case.checks
    }


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_truth_passes_every_check_at_every_step(case: Case) -> None:
    for dt in case.ladder:
        assert all(verdicts(case, at_rest(case, dt)).values())


def tip(run: Trajectory, place: int) -> None:
    run.p_WB[40:, place, 2] *= 0.3


def sway(run: Trajectory, place: int) -> None:
    run.v_WB[:, place, 0] = 0.2


def sink(run: Trajectory, place: int) -> None:
    run.p_WB[30:, place, 2] -= 1e-2


FAULTS: list[tuple[Case, Callable[[Trajectory, int], None], int, str]] = [
    (stack_mass_ratio.CASE, tip, 2, "collapse_time"),
    (stack_mass_ratio.CASE, sink, 2, "stack_height_error"),
    (stack_mass_ratio.CASE, sway, 1, "rms_speed"),
    (stack_heavy_on_two.CASE, tip, 3, "collapse_time"),
    (stack_heavy_on_two.CASE, sway, 1, "settled_share_high"),
    (stack_pyramid.CASE, tip, 20, "collapse_time"),
    (stack_pyramid.CASE, sink, 12, "rest_drift"),
    (stack_pyramid.CASE, sway, 8, "rms_speed"),
    (stack_overlap_recovery.CASE, sway, 2, "rms_speed"),
    (stack_overlap_recovery.CASE, sway, 2, "residual_kinetic_energy"),
]


@pytest.mark.parametrize(
    ("case", "fault", "place", "check"), FAULTS, ids=lambda x: getattr(x, "name", getattr(x, "__name__", x))
)
def test_each_planted_fault_fails_its_own_check(
    case: Case, fault: Callable[[Trajectory, int], None], place: int, check: str
) -> None:
    run = at_rest(case)
    fault(run, place)
    assert not verdicts(case, run)[check]


def test_a_ground_that_bears_a_tenth_less_fails() -> None:
    for case in (stack_mass_ratio.CASE, stack_pyramid.CASE):
        run = at_rest(case)
        assert run.contacts is not None
        light = replace(run.contacts[0], force_W=0.9 * run.contacts[0].force_W)
        assert not verdicts(case, replace(run, contacts=(light,) * len(run)))["support_force_error"]


# --- heavy on light -------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_the_heavy_cube_is_as_large_as_the_light_one(ratio: float) -> None:
    _, light, heavy = stack_mass_ratio.scene(stack_mass_ratio.P(ratio)).bodies
    assert light.collision == heavy.collision
    assert heavy.mass == ratio * light.mass
    np.testing.assert_allclose(np.array(heavy.inertia), ratio * np.array(light.inertia), rtol=1e-15)
    assert heavy.p_WB[2] - light.p_WB[2] == pytest.approx(2 * light.p_WB[2])


# --- heavy on two ---------------------------------------------------------------------------------


def test_the_heavy_box_falls_freely_until_it_touches_both() -> None:
    stage = stack_heavy_on_two.scene(stack_heavy_on_two.P(drop=0.1))
    fall = math.sqrt(0.2 / G)
    truth = stack_heavy_on_two.expected(np.array([0.0, fall / 2, fall * 1.0001, 1.0]), stack_heavy_on_two.P(drop=0.1))
    gaps = truth.p_WB[:, 3, 2] - stack_heavy_on_two.LARGE[2] - 2 * stack_heavy_on_two.SMALL
    np.testing.assert_allclose(gaps, [0.1, 0.1 - 0.025, 0.0, 0.0], atol=1e-12)
    assert truth.v_WB[1, 3, 2] == pytest.approx(-G * fall / 2)
    assert not truth.v_WB[2:].any()
    shape = stage.bodies[3].collision[0].shape
    assert isinstance(shape, Box)
    assert shape.half_extents[0] >= stack_heavy_on_two.APART + stack_heavy_on_two.SMALL


def test_pressures_at_the_edges_of_the_supports_split_the_load_as_the_bound_says() -> None:
    # Levers: forces at -d + s and d + s balance about the middle at (d + s)/(2 d), one half and s/(2 d) more.
    d, s = stack_heavy_on_two.APART, stack_heavy_on_two.SMALL
    left = np.linalg.solve([[1.0, 1.0], [-d + s, d + s]], [1.0, 0.0])[0]
    (check,) = (c for c in stack_heavy_on_two.CASE.checks if c.metric.name == "load_split_error")
    assert left - 0.5 == pytest.approx(s / (2 * d))
    assert left - 0.5 < check.bound(1e-9, stack_heavy_on_two.CASE.parameters) < left - 0.5 + 1e-6


def test_a_load_that_leans_on_one_support_fails() -> None:
    run = at_rest(stack_heavy_on_two.CASE)
    assert run.contacts is not None
    scale = np.where(run.contacts[0].body_B == 3, 1.3, 1.0) * np.where(run.contacts[0].body_A == 2, 0.7 / 1.3, 1.0)
    skew = replace(run.contacts[0], force_W=run.contacts[0].force_W * scale[:, None])
    assert not verdicts(stack_heavy_on_two.CASE, replace(run, contacts=(skew,) * len(run)))["load_split_error"]


# --- pyramids -------------------------------------------------------------------------------------


def gap(a: Body, b: Body) -> float:
    """Between balls, or of a ball over a plane [m]."""
    one, two = a.collision[0].shape, b.collision[0].shape
    assert isinstance(two, Sphere)
    if isinstance(one, Sphere):
        return math.dist(a.p_WB, b.p_WB) - one.radius - two.radius
    assert isinstance(one, Plane)
    normal = np.array(rotate(a.q_WB, one.normal))
    return float((np.array(b.p_WB) - np.array(a.p_WB)) @ normal) - two.radius


def touches(stage: Scene, ball: Body) -> tuple[int, int]:
    """How many balls and walls touch a ball; none may be overlapped."""
    others = [b for b in stage.bodies if b.material in ("ball", "wall") and b.name != ball.name]
    gaps = [(b.material, gap(b, ball)) for b in others]
    assert min(g for _, g in gaps) > -1e-12
    near = [m for m, g in gaps if g < 1e-12]
    return near.count("ball"), near.count("wall")


@pytest.mark.parametrize("rows", [1, 3, 4])
def test_balls_touch_those_below_and_the_walls_at_the_edge_of_their_layer(rows: int) -> None:
    stage = stack_pyramid.scene(stack_pyramid.P(rows))
    for ball in (b for b in stage.bodies if b.material == "ball"):
        row, i, j = (int(x) for x in ball.name.split("_")[1:])
        edges = (i == 0) + (i == row) + (j == 0) + (j == row)
        below = sum(0 <= i + a < row and 0 <= j + b < row for a in (-1, 0) for b in (-1, 0))
        above = 4 if row + 1 < rows else 0
        beside = sum(0 <= i + a <= row and 0 <= j + b <= row for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1)))
        assert touches(stage, ball) == (below + above + beside, edges)


def equilibrium(stage: Scene, bodies: list[Body], links: list[tuple[int, int, Floats]]) -> float:
    """What is left of the weights after the best forces along the links, each (a or -1, b, direction on b), that only push."""
    from scipy.optimize import nnls

    rows = np.zeros((3 * len(bodies), len(links)))
    for k, (a, b, way) in enumerate(links):
        rows[3 * b : 3 * b + 3, k] += way
        if a >= 0:
            rows[3 * a : 3 * a + 3, k] -= way
    weights = np.concatenate([-body.mass * np.array(stage.gravity) for body in bodies])
    return float(nnls(rows, weights)[1] / np.linalg.norm(weights))


@pytest.mark.parametrize("rows", [1, 3, 5])
def test_forces_along_the_normals_alone_hold_the_balls(rows: int) -> None:
    stage = stack_pyramid.scene(stack_pyramid.P(rows))
    balls = [b for b in stage.bodies if b.material == "ball"]
    links = []
    for (i, a), (j, b) in combinations(enumerate(balls), 2):
        if gap(a, b) < 1e-9:
            way = np.array(b.p_WB) - np.array(a.p_WB)
            links.append((i, j, way / np.linalg.norm(way)))
    for wall in (b for b in stage.bodies if b.material == "wall"):
        shape = wall.collision[0].shape
        assert isinstance(shape, Plane)
        links += [(-1, j, np.array(shape.normal)) for j, b in enumerate(balls) if gap(wall, b) < 1e-9]
    assert equilibrium(stage, balls, links) < 1e-9


@pytest.mark.parametrize("rows", [2, 3, 6])
def test_each_brick_lies_across_the_joint_of_the_two_below_and_touches_no_neighbour(rows: int) -> None:
    bricks = [b for b in stack_pyramid.scene(stack_pyramid.P(rows)).bodies if b.material == "brick"]
    assert len(bricks) == rows * (rows + 1) // 2
    a, _, c = stack_pyramid.HALF
    for brick in bricks:
        others = [b for b in bricks if b.name != brick.name]
        overlapping = [b for b in others if abs(b.p_WB[0] - brick.p_WB[0]) < 2 * a]
        below = [b for b in overlapping if b.p_WB[2] < brick.p_WB[2] - 1e-9 and brick.p_WB[2] - b.p_WB[2] < 3 * c]
        levels = [(b.p_WB[2] - brick.p_WB[2]) / (2 * c) for b in overlapping]
        assert all(abs(level - round(level)) < 1e-9 and round(level) != 0 for level in levels)
        lowest = brick.p_WB[2] == pytest.approx(c)
        assert len(below) == (0 if lowest else 2)
        # The centre of mass lies between the middles of the two strips on which it rests.
        if below:
            left, right = sorted(b.p_WB[0] for b in below)
            assert left < brick.p_WB[0] < right


# --- overlap --------------------------------------------------------------------------------------


@pytest.mark.parametrize("overlap", [0.0, 0.25, 0.45])
def test_the_upper_cube_starts_a_share_of_an_edge_inside_the_lower(overlap: float) -> None:
    _, lower, upper = stack_overlap_recovery.scene(stack_overlap_recovery.P(overlap)).bodies
    edge = 2 * stack_overlap_recovery.HALF
    assert lower.p_WB[2] + edge - upper.p_WB[2] == pytest.approx(overlap * edge)
    rest = stack_overlap_recovery.expected(np.zeros(1), stack_overlap_recovery.P(overlap=overlap)).p_WB[0]
    assert rest[2, 2] - rest[1, 2] == pytest.approx(edge)


def test_boxes_that_stay_inside_each_other_or_are_thrown_apart_fail() -> None:
    case = stack_overlap_recovery.CASE
    run = at_rest(case)
    run.p_WB[:, 2, 2] -= 0.03
    assert not verdicts(case, run)["penetration"]
    thrown = at_rest(case)
    flight = np.minimum(thrown.time, 2 * 0.5 / G)
    thrown.p_WB[:, 2, 2] += 0.5 * flight - G * flight**2 / 2
    assert not verdicts(case, thrown)["ejection_speed"]
