"""Joints beside contacts under the exact solver: closed forms, and one step by enumeration of all active sets."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from plumbline import engine
from tests.exact_worlds import DEFAULT, DT, EXACT, GROUND, G, ball, cube, residual, surface

NOTHING = (0.0, 0.0, 0.0)
UP = (0.0, 1.0, 0.0)
"""Hinges turn about y."""


def _world(bodies: list[engine.Body], joints: list[Any], law: engine.Surface, **chosen: Any) -> engine.World:
    gravity = chosen.pop("gravity", (0.0, 0.0, -G))
    options = engine.Options(solver="exact", substeps=1, **chosen)
    return engine.World(bodies, joints, surfaces={DEFAULT: law}, gravity=gravity, options=options)


def _table(top: float, leg: float) -> engine.World:
    """A plate on four pins, upright capsules .6 m long, fixed to it."""
    inertia = top / 3 * np.diag((0.3**2 + 0.02**2, 0.5**2 + 0.02**2, 0.5**2 + 0.3**2))
    plate = engine.Placed(engine.Box((0.5, 0.3, 0.02)))
    bodies = [GROUND, engine.Body(name="top", mass=top, inertia=inertia, p_WB=(0, 0, 0.62), shapes=[plate])]
    for k, (x, y) in enumerate(((0.4, 0.2), (-0.4, 0.2), (-0.4, -0.2), (0.4, -0.2))):
        pin = engine.Placed(engine.Capsule(0.02, 0.28))
        spread = leg / 12 * 0.36 * np.diag((1.0, 1.0, 0.01))
        bodies.append(engine.Body(name=f"leg{k}", mass=leg, inertia=spread, p_WB=(x, y, 0.3), shapes=[pin]))
    return _world(bodies, [engine.Fixed(name=f"pin{k}", parent="top", child=f"leg{k}") for k in range(4)], surface(0.5))


@pytest.mark.parametrize("top", [4.0, 4000.0])
def test_a_table_stands_on_four_legs_each_pair_of_which_carries_half_of_the_plate(top: float) -> None:
    """Three equations for four legs: the sums of neighbours are given by moments, and one force, of one diagonal against the
    other, by nothing; so it is not asked for. Round-off is that of g dt times the ratio of masses."""
    table = _table(top, 0.5)
    before = table.state()[:, :3].copy()
    table.step(20)
    assert residual(table) <= EXACT
    assert np.abs(table.state()[:, :3] - before).max() < 1e-11
    assert np.abs(table.state()[:, 7:]).max() < 1e-10
    assert abs(table.contacts().force[:, 2].sum()) == pytest.approx((top + 2.0) * G, rel=1e-9)
    down = [table.reaction(f"pin{k}")[2] for k in range(4)]
    assert sum(down) == pytest.approx(-top * G, rel=1e-9)
    assert [down[0] + down[1], down[1] + down[2]] == pytest.approx([-top * G / 2] * 2, rel=1e-8)


def _leaning(angle: float, friction: float = 0.0) -> engine.World:
    """Two rods of 1 kg and .5 m in line, fixed to each other, the lower one on a hinge at the origin, the tip against a
    wall."""
    way = np.array([math.cos(angle), 0.0, math.sin(angle)])
    radius = 0.02
    wall = engine.Body(
        name="wall", motion="static", p_WB=(way[0] + radius, 0, 0), shapes=[engine.Placed(engine.Plane((-1, 0, 0)))]
    )
    half = (math.pi / 2 - angle) / 2
    rods = [
        engine.Body(
            name=name, mass=1.0, inertia=0.25 / 12 * np.diag((1.0, 1.0, 0.01)), p_WB=tuple(at * way),
            q_WB=(math.cos(half), 0, math.sin(half), 0), shapes=shapes,
        )
        for name, at, shapes in (
            ("low", 0.25, []), ("high", 0.75, [engine.Placed(engine.Sphere(radius), p_BS=(0, 0, 0.25))]),
        )
    ]  # fmt: skip
    joints = [
        engine.Revolute(name="foot", parent=engine.WORLD, child="low", anchor_W=(0, 0, 0), axis_W=UP),
        engine.Fixed(name="middle", parent="low", child="high"),
    ]
    return _world([wall, *rods], joints, surface(friction))


@pytest.mark.parametrize("angle", [0.5, 1.2])
def test_two_rods_in_line_lean_on_a_wall_with_half_of_their_weight_over_the_tangent(angle: float) -> None:
    """Moments about the hinge: N l sin = 2 m g l cos / 2. The hinge carries the rest: N from the wall, both weights upwards."""
    leaning = _leaning(angle)
    leaning.step(10)
    normal = 2.0 * G / (2.0 * math.tan(angle))
    assert residual(leaning) <= EXACT
    assert np.abs(leaning.contacts().force[:, 0]).sum() == pytest.approx(normal, rel=1e-8)
    assert leaning.reaction("foot")[:3] == pytest.approx([normal, 0.0, 2.0 * G], abs=1e-7)
    assert np.abs(leaning.state()[:, 7:]).max() < 1e-10


@pytest.mark.parametrize(("friction", "slides"), [(0.3, True), (0.9, False)])
def test_two_boxes_on_a_hinge_slide_as_one(friction: float, slides: bool) -> None:
    """Gravity turned to tan = .6: v = g (sin - mu cos) t, or rest. The bias of the joint's gaps is what g dt^2 leaves:
    nothing."""
    lean = math.atan(0.6)
    boxes = [cube("one", 1.0, 0.1, p_WB=(-0.15, 0, 0.1)), cube("two", 2.0, 0.1, p_WB=(0.15, 0, 0.1))]
    hinge = engine.Revolute(name="hinge", parent="one", child="two", anchor_W=(0, 0, 0.1), axis_W=UP)
    gravity = (G * math.sin(lean), 0.0, -G * math.cos(lean))
    world = _world([GROUND, *boxes], [hinge], surface(friction), gravity=gravity)
    world.step(24)
    speed = G * (math.sin(lean) - friction * math.cos(lean)) * 24 * DT if slides else 0.0
    assert residual(world) <= EXACT
    assert world.state()[1:, 7] == pytest.approx([speed, speed], abs=1e-8)


def _enumerated(mass: np.ndarray, held: np.ndarray, bears: np.ndarray, free: np.ndarray, due: np.ndarray) -> np.ndarray:
    """Velocities after a step without friction: held @ v = 0, bears @ v >= -due, by the one active set that fits."""
    for chosen in product((False, True), repeat=len(bears)):
        on = np.array(chosen)
        rows, n = np.vstack([held, bears[on]]), len(mass)
        matrix = np.zeros((n + len(rows),) * 2)
        matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = mass, -rows.T, rows
        right = np.concatenate([mass @ free, np.zeros(len(held)), -due[on]])
        solved = np.linalg.solve(matrix, right)
        v, pushes = solved[:n], solved[n + len(held) :]
        if (pushes >= -1e-12).all() and (bears @ v >= -due - 1e-12).all():
            return np.asarray(v)
    raise AssertionError("one active set fits")


@pytest.mark.parametrize("seed", range(6))
def test_a_step_of_jointed_balls_on_a_floor_is_that_of_the_one_active_set_that_fits(seed: int) -> None:
    """Three balls in a row on ball joints, without friction, at gaps that a step closes or not: the whole system of masses,
    joints and contacts solved for each of the eight sets of points that may bear."""
    rng, radius = np.random.default_rng(seed), 0.1
    mass, height = rng.uniform(0.5, 5.0, 3), radius + np.maximum(rng.uniform(-2e-3, 4e-3, 3), 0.0)
    place = [np.array([0.3 * k, 0.0, height[k]]) for k in range(3)]
    start, spin = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    anchors = [0.5 * (place[k] + place[k + 1]) for k in range(2)]
    # Only velocities that the joints allow are a start: those of one rigid body.
    turn, middle = spin[0], place[1]
    start = np.array([start[0] + np.cross(turn, p - middle) for p in place])
    balls = [ball(f"b{k}", mass[k], radius, p_WB=tuple(place[k]), v_WB=tuple(start[k]), w_WB=tuple(turn)) for k in range(3)]
    joints = [engine.Ball(name=f"j{k}", parent=f"b{k}", child=f"b{k + 1}", anchor_W=tuple(anchors[k])) for k in range(2)]
    world = _world([GROUND, *balls], joints, surface())
    world.step()

    def cross(r: np.ndarray) -> np.ndarray:
        return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])

    held, bears = np.zeros((6, 18)), np.zeros((3, 18))
    for k in range(2):
        rows = slice(3 * k, 3 * k + 3)
        for b, sign in ((k, -1.0), (k + 1, 1.0)):
            held[rows, 6 * b : 6 * b + 3] = sign * np.eye(3)
            held[rows, 6 * b + 3 : 6 * b + 6] = -sign * cross(anchors[k] - place[b])
    free = np.concatenate([np.concatenate([start[k] + DT * np.array([0, 0, -G]), turn]) for k in range(3)])
    for k in range(3):
        bears[k, 6 * k + 2] = 1.0
    everything = np.diag(np.concatenate([np.repeat((m, 0.4 * m * radius**2), 3) for m in mass]))
    due = np.maximum(height - radius - 1e-9, 0.0) / DT
    v = _enumerated(everything, held, bears, free, due).reshape(3, 6)
    assert residual(world) <= EXACT
    assert world.state()[1:, 7:] == pytest.approx(v, abs=1e-8)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a_dumbbell_that_strikes_with_one_end_rebounds_as_a_rigid_body(restitution: float) -> None:
    """Impulse (1 + e) v / (1 / M + d^2 / I) at the distance d from the centre of mass, all closed form; nothing else acts."""
    radius, length, tilt, speed = 0.1, 0.6, 0.4, 2.0
    ends = [0.5 * length * sign * np.array([math.cos(tilt), 0.0, math.sin(tilt)]) for sign in (-1.0, 1.0)]
    height = radius + 0.5 * length * math.sin(tilt) + 0.5e-3
    balls = [
        ball(name, 1.0, radius, p_WB=(end[0], end[1], end[2] + height), v_WB=(0, 0, -speed))
        for name, end in zip(("low", "high"), ends, strict=True)
    ]
    bar = engine.Fixed(name="bar", parent="low", child="high")
    world = _world([GROUND, *balls], [bar], surface(0.0, restitution), gravity=NOTHING)
    world.step()
    arm, total, inertia = 0.5 * length * math.cos(tilt), 2.0, 2 * (0.4 * radius**2 + (0.5 * length) ** 2)
    push = (1.0 + restitution) * speed / (1.0 / total + arm**2 / inertia)
    state = world.state()[1:]
    assert residual(world) <= EXACT
    assert state[:, 9].mean() == pytest.approx(-speed + push / total, abs=1e-6 if restitution else 0.2)
    assert state[:, 11] == pytest.approx([arm * push / inertia] * 2, abs=1e-6 if restitution else 0.2)
    if restitution == 1.0:
        energy = 0.5 * (state[:, 7:10] ** 2).sum() + 0.2 * radius**2 * (state[:, 10:] ** 2).sum()
        assert energy == pytest.approx(0.5 * total * speed**2, rel=1e-9)


def test_a_stop_and_a_block_hold_two_rods() -> None:
    """The elbow's stop bears the outer rod: moment m g l / 2 about the hinge, to round-off of what does not move."""

    def rod(name: str, x: float) -> engine.Body:
        return engine.Body(
            name=name, mass=1.0, inertia=np.diag((1e-3, 0.16 / 12, 0.16 / 12)), p_WB=(x, 0, 0.1),
            shapes=[engine.Placed(engine.Box((0.2, 0.02, 0.02)))],
        )  # fmt: skip

    block = engine.Body(
        name="block", motion="static", p_WB=(0.35, 0, 0.04), shapes=[engine.Placed(engine.Box((0.02, 0.1, 0.04)))]
    )
    joints = [
        engine.Revolute(name="shoulder", parent=engine.WORLD, child="inner", anchor_W=(0, 0, 0.1), axis_W=UP),
        engine.Revolute(
            name="elbow", parent="inner", child="outer", anchor_W=(0.4, 0, 0.1), axis_W=UP, limits=engine.Limits(upper=0.0)
        ),
    ]
    world = _world([block, rod("inner", 0.2), rod("outer", 0.6)], joints, surface(0.5))
    world.step(20)
    assert residual(world) <= EXACT
    assert np.abs(world.state()[1:, 7:]).max() < 1e-9
    assert abs(world.reaction("elbow")[4]) == pytest.approx(G * 0.2, rel=1e-7)


def test_a_spring_presses_a_slide_onto_the_floor_with_what_it_is_short_of() -> None:
    """N = m g + k x, x = .05 m being the way from its rest; a drive adds as much again."""
    law = {"spring": engine.Spring(stiffness=200.0, damping=5.0, rest=-0.05)}
    more = {"drive": engine.Drive(stiffness=100.0, damping=1.0, target=-0.1)}
    for given, force in ((law, 200 * 0.05), ({**law, **more}, 200 * 0.05 + 100 * 0.1)):
        ends: Any = {"parent": engine.WORLD, "child": "cube", **given}
        slide = engine.Prismatic(name="slide", anchor_W=(0, 0, 0.1), axis_W=(0, 0, 1), **ends)
        world = _world([GROUND, cube(p_WB=(0, 0, 0.1))], [slide], surface(0.5))
        world.step(20)
        assert residual(world) <= EXACT
        assert abs(world.contacts().force[:, 2].sum()) == pytest.approx(G + force, rel=1e-7)


def test_a_joint_told_twice_carries_what_it_carries_once() -> None:
    """Two boxes fixed to each other twice over, one of them on the floor: rows that depend on others share, and open
    nothing."""

    def stand(times: int) -> engine.World:
        boxes = [cube("low", p_WB=(0, 0, 0.1)), cube("high", 2.0, p_WB=(0.15, 0, 0.35))]
        joints = [engine.Fixed(name=f"weld{k}", parent="low", child="high") for k in range(times)]
        return _world([GROUND, *boxes], joints, surface(0.5))

    one, two = stand(1), stand(2)
    for world in (one, two):
        world.step(12)
        assert residual(world) <= EXACT
    assert two.state() == pytest.approx(one.state(), abs=1e-9)
    both = two.reaction("weld0") + two.reaction("weld1")
    assert both == pytest.approx(one.reaction("weld0"), abs=1e-7)


def test_jointed_bodies_and_a_box_that_meet_in_the_air_keep_their_momentum() -> None:
    """Contacts and joints give both sides the same: 1e-15 of what there is, times a hundred steps."""
    bodies = [
        ball("a", 1.0, p_WB=(0, 0, 1)),
        ball("b", 2.0, p_WB=(0.3, 0, 1)),
        cube("c", 3.0, p_WB=(0.1, 0, 1.3), v_WB=(0, 0.1, -2.0)),
    ]
    joints = [engine.Ball(name="j", parent="a", child="b", anchor_W=(0.15, 0, 1))]
    world = _world([GROUND, *bodies], joints, surface(0.5), gravity=NOTHING)
    mass = np.array([1.0, 2.0, 3.0])
    before = mass @ world.state()[1:, 7:10]
    world.step(40)
    assert residual(world) <= EXACT
    assert world.state()[3, 9] > -1.9
    assert mass @ world.state()[1:, 7:10] == pytest.approx(before, abs=1e-12)


def test_a_chain_comes_to_lie_where_the_soft_solver_lays_it() -> None:
    """Three capsules on ball joints fall by 1 cm: both lie a radius above the floor, soft ones a hundredth of a millimetre
    deep, and have gone no further apart than steps of 1/240 s at the speed of the fall, .44 m/s, place the blow."""

    def chain(**chosen: Any) -> engine.World:
        bodies, joints = [GROUND], []
        for k in range(3):
            bodies.append(engine.Body(
                name=f"link{k}", mass=0.5, inertia=np.diag((0.002, 0.002, 0.0005)), p_WB=(0.2 * k, 0, 0.04),
                q_WB=(math.sqrt(0.5), 0, math.sqrt(0.5), 0), shapes=[engine.Placed(engine.Capsule(0.03, 0.06))],
            ))  # fmt: skip
            if k:
                ends: Any = {"parent": f"link{k - 1}", "child": f"link{k}"}
                joints.append(engine.Ball(name=f"j{k}", anchor_W=(0.2 * k - 0.1, 0, 0.04), **ends))
        options = engine.Options(**chosen)
        return engine.World(bodies, joints, surfaces={DEFAULT: surface(0.5)}, options=options)

    exact, soft = chain(solver="exact", substeps=1), chain(substeps=16)
    for world in (exact, soft):
        world.step(60)
    assert residual(exact) <= EXACT
    assert exact.state()[1:, 2] == pytest.approx([0.03] * 3, abs=1e-6)
    assert np.abs(exact.state()[1:, 7:]).max() < 1e-8
    assert np.abs(exact.state()[1:, :3] - soft.state()[1:, :3]).max() < 0.44 / 240


def test_what_acts_within_bounds_along_a_joint_is_refused_by_its_name() -> None:
    for given, what in (
        ({"friction_loss": 0.1}, "dry friction in joint 'hinge'"),
        ({"speed_limit": 1.0}, "a limit of speed in joint 'hinge'"),
        ({"drive": engine.Drive(stiffness=1.0, limit=5.0)}, "a limited drive in joint 'hinge'"),
    ):
        ends: Any = {"parent": engine.WORLD, "child": "cube", **given}
        hinge = engine.Revolute(name="hinge", anchor_W=(0, 0, 0.1), axis_W=UP, **ends)
        with pytest.raises(engine.NotSupported, match=what):
            _world([GROUND, cube(p_WB=(0, 0, 0.1))], [hinge], surface(0.5))
