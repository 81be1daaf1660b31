"""Bounding volumes: none drops a pair of shapes that touch, and the choice among them changes no motion."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from plumbline import engine
from plumbline.engine.build.solids import quat_mat, quat_mul
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.arena import float_table, int_table
from plumbline.engine.options import BOUNDING_VOLUMES
from tests.forks import Fork

DEFAULT = ("default", "default")
FloatArray = NDArray[np.float64]


def _shape(rng: np.random.Generator, kind: int) -> engine.Shape:
    """A shape of the kind, up to 1 m wide and as flat or long as a hundredth of that."""
    a, b, c = 10.0 ** rng.uniform(-2, 0, 3)
    if kind == 0:
        return engine.Sphere(a)
    if kind == 1:
        return engine.Box((a, b, c))
    if kind == 2:
        return engine.Capsule(a, b)
    if kind == 3:
        return engine.Cylinder(a, b)
    return engine.ConvexHull((rng.normal(size=(10, 3)) * (a, b, c)).tolist())


def _samples(rng: np.random.Generator, shape: engine.Shape, number: int) -> FloatArray:
    """Points of a shape in its own frame, on its surface or inside."""
    u = rng.normal(size=(number, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    spread = rng.uniform(size=(number, 1)) ** 0.1
    if isinstance(shape, engine.Sphere):
        return np.asarray(shape.radius * spread * u)
    if isinstance(shape, engine.Box):
        corners = np.clip(2.0 * u * spread, -1, 1)
        return np.asarray(corners * shape.half_extents)
    if isinstance(shape, engine.Capsule):
        spine = rng.uniform(-1, 1, (number, 1)) * (0, 0, shape.half_length)
        return np.asarray(spine + shape.radius * spread * u)
    if isinstance(shape, engine.Cylinder):
        turn = rng.uniform(0, 2 * math.pi, number)
        rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(number)]) * shape.radius * spread
        return np.asarray(rim + np.where(rng.uniform(size=(number, 1)) < 0.5, -1, 1) * (0, 0, shape.half_length))
    assert isinstance(shape, engine.ConvexHull)
    weights = rng.dirichlet(np.full(len(shape.vertices), 0.1), number)
    return np.asarray(np.vstack([weights @ np.asarray(shape.vertices), shape.vertices]))


def _world(bodies: list[engine.Body], volume: str, **options: float) -> engine.World:
    return engine.World(bodies, options=engine.Options(broad_phase="brute_force", bounding_volume=volume, **options))  # type: ignore[arg-type]


def _pairs(world: engine.World) -> set[tuple[int, int]]:
    """The pairs of the coming step."""
    if world._find_pairs is None:
        # So few shapes are compared inside the step.
        from plumbline.engine.broad.brute_force import find_pairs

        assert find_pairs(world._floats, world._ints) == 0
    else:
        assert world._search() == 0
    number = int_table(world._ints, at.COUNT)[0, at.PAIRS]
    return {(int(i), int(j)) for i, j in int_table(world._ints, at.PAIR)[:number]}


def _points(world: engine.World, shape: engine.Shape, s: int, rng: np.random.Generator) -> FloatArray:
    """Samples of shape s of a world, in W."""
    pose = float_table(world._floats, world._ints, at.POSE)[s]
    points = _samples(rng, shape, 1000)
    if isinstance(shape, engine.ConvexHull):
        vertices = np.asarray(shape.vertices)
        points = points - (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    return np.asarray(pose[:3] + points @ pose[3:].reshape(3, 3).T)


VOLUMES = pytest.mark.parametrize("volume", BOUNDING_VOLUMES)
SEEDS = st.integers(0, 2**32 - 1)
NEAR = given(
    seed=SEEDS, kinds=st.tuples(st.integers(0, 4), st.integers(0, 4)), far=st.sampled_from([0.0, 1e3, 1e6]),
    aligned=st.booleans(),
)  # fmt: skip
MEETING = given(seed=SEEDS, kind=st.integers(0, 4))
ON_A_PLANE = given(seed=SEEDS, kind=st.integers(0, 4), below=st.booleans())


@VOLUMES
@settings(max_examples=25, deadline=None)
@NEAR
@example(seed=0, kinds=(1, 1), far=0.0, aligned=True)
def test_shapes_with_points_near_each_other_are_a_pair(
    volume: str, seed: int, kinds: tuple[int, int], far: float, aligned: bool
) -> None:
    """The second shape is moved until a point of it lies within the margin of a point of the first: the volumes must overlap.

    The bounds are widened by at least twice the margin. The samples lie on the shapes up to the rounding of a place `far` away,
    which is below a millionth of the margin.
    """
    rng = np.random.default_rng(seed)
    shapes = [_shape(rng, kind) for kind in kinds]
    turns = [(1.0, 0.0, 0.0, 0.0)] * 2 if aligned else [tuple(q) for q in rng.normal(size=(2, 4))]
    bodies = [
        engine.Body(name=str(k), shapes=[engine.Placed(shapes[k])], p_WB=(far, far, far), q_WB=turns[k]) for k in range(2)
    ]
    world = _world(bodies, volume)
    assert _pairs(world) == {(0, 1)}
    one, two = (_points(world, shapes[k], k, rng) for k in range(2))
    # Along a random direction, the outermost point of one is put against the innermost of the other.
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    gap = 0.9 * world.options.margin
    world.state()[1, :3] += one[(one @ n).argmax()] - two[(two @ n).argmin()] + gap * n
    assert _pairs(world) == {(0, 1)}


@VOLUMES
@settings(max_examples=20, deadline=None)
@MEETING
def test_what_meets_within_a_step_is_a_pair_before_it(volume: str, seed: int, kind: int) -> None:
    """Two bodies that fly and spin are put where two of their points meet at the end of a step: the widening covers the way."""
    rng = np.random.default_rng(seed)
    shapes = [_shape(rng, kind), _shape(rng, int(rng.integers(5)))]
    speeds = rng.normal(size=(2, 2, 3)) * 10.0
    bodies = [
        engine.Body(
            name=str(k), shapes=[engine.Placed(shapes[k])], q_WB=rng.normal(size=4), v_WB=speeds[k, 0], w_WB=speeds[k, 1]
        )
        for k in range(2)
    ]
    world, dt = _world(bodies, volume), 1 / 240
    _pairs(world)
    now = [_points(world, shapes[k], k, rng) for k in range(2)]
    later = []
    for k in range(2):
        angle = float(np.linalg.norm(speeds[k, 1])) * dt
        axis = speeds[k, 1] / np.linalg.norm(speeds[k, 1])
        cos, sin = math.cos(angle), math.sin(angle)
        turned = now[k] * cos + np.cross(axis, now[k]) * sin + np.outer(now[k] @ axis, axis) * (1 - cos)
        later.append(turned + speeds[k, 0] * dt)
    n = rng.normal(size=3)
    world.state()[1, :3] += later[0][(later[0] @ n).argmax()] - later[1][(later[1] @ n).argmin()]
    assert _pairs(world) == {(0, 1)}


@VOLUMES
@settings(max_examples=20, deadline=None)
@ON_A_PLANE
def test_what_reaches_a_plane_is_a_pair_with_it(volume: str, seed: int, kind: int, below: bool) -> None:
    """The lowest of the sampled points is put within the margin of a plane, on either side, whichever shape is the first."""
    rng = np.random.default_rng(seed)
    n, shape = rng.normal(size=3), _shape(rng, kind)
    n /= np.linalg.norm(n)
    plane = engine.Body(name="plane", motion="static", shapes=[engine.Placed(engine.Plane(tuple(n)))], p_WB=rng.normal(size=3))
    body = engine.Body(name="body", shapes=[engine.Placed(shape)], q_WB=rng.normal(size=4))
    for bodies, b in (([plane, body], 1), ([body, plane], 0)):
        world = _world(bodies, volume)
        _pairs(world)
        lowest = _points(world, shape, b, rng) @ n
        gap = -0.5 if below else 0.9 * world.options.margin
        world.state()[b, :3] += (plane.p_WB @ n + gap - lowest.min()) * n
        assert _pairs(world) == {(0, 1)}


@pytest.mark.slow
@VOLUMES
@pytest.mark.parametrize(
    ("test", "draws"),
    [
        (test_shapes_with_points_near_each_other_are_a_pair, NEAR),
        (test_what_meets_within_a_step_is_a_pair_before_it, MEETING),
        (test_what_reaches_a_plane_is_a_pair_with_it, ON_A_PLANE),
    ],
    ids=["near", "meeting", "on a plane"],
)
def test_so_it_is_in_sixty_draws(volume: str, test: Any, draws: Callable[[Any], Any]) -> None:
    """Each of the three above, for longer."""

    @settings(max_examples=60, deadline=None)
    @draws
    def longer(**drawn: Any) -> None:
        test.hypothesis.inner_test(volume, **drawn)

    longer()


def test_each_volume_drops_what_only_a_looser_one_keeps() -> None:
    """Two long boxes side by side, askew, overlap in their axis-aligned boxes only; two balls at a corner in any box."""
    turn = (math.cos(math.pi / 8), 0.0, 0.0, math.sin(math.pi / 8))
    long = engine.Placed(engine.Box((1.0, 0.01, 0.01)))
    beside = [engine.Body(name=str(k), shapes=[long], q_WB=turn, p_WB=(0.3 * k, -0.3 * k, 0.0)) for k in range(2)]
    ball = engine.Placed(engine.Sphere(1.0))
    corner = [engine.Body(name=str(k), shapes=[ball], p_WB=(1.9 * k, 1.9 * k, 1.9 * k)) for k in range(2)]
    kept = [(_pairs(_world(beside, volume)) != set(), _pairs(_world(corner, volume)) != set()) for volume in BOUNDING_VOLUMES]
    assert dict(zip(BOUNDING_VOLUMES, kept, strict=True)) == {
        "aabb": (True, True),
        "obb": (False, True),
        "sphere": (True, False),
    }


def test_boxes_parted_by_a_cross_product_of_edges_alone_are_apart() -> None:
    """Two thin rods that cross askew, one over the other: no face normal parts them, the cross product of their edges does."""
    rod = engine.Placed(engine.Box((1.0, 0.05, 0.05)))
    half = math.sqrt(0.5)
    # Both are turned by 45 degrees about their own axes, so that edges and not faces look at each other.
    rolled = np.array([math.cos(math.pi / 8), math.sin(math.pi / 8), 0.0, 0.0])
    across = np.array([half * rolled[0], half * rolled[1], half * rolled[1], half * rolled[0]])
    apart = 2 * 0.05 * math.sqrt(2)
    # All is turned, so that the axis between them is none of the world's.
    askew = np.array([math.cos(0.4), *(math.sin(0.4) * np.ones(3) / math.sqrt(3))])
    for gap, expected in ((0.01, set()), (-0.01, {(0, 1)})):
        bodies = [
            engine.Body(name="0", shapes=[rod], q_WB=quat_mul(askew, rolled)),
            engine.Body(name="1", shapes=[rod], q_WB=quat_mul(askew, across), p_WB=quat_mat(askew) @ (0.0, 0.0, apart + gap)),
        ]
        assert _pairs(_world(bodies, "aabb")) == {(0, 1)}
        assert _pairs(_world(bodies, "obb")) == expected


def _heap(volume: str, **options: object) -> engine.World:
    """Thirty bodies of all kinds falling onto a plane and a mesh."""
    rng = np.random.default_rng(11)
    corners = ((-1.0, -1.0, 0.1), (1.0, -1.0, 0.1), (1.0, 1.0, 0.1), (-1.0, 1.0, 0.1))
    bodies = [
        engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())]),
        engine.Body(name="slab", motion="static", shapes=[engine.Placed(engine.TriangleMesh(corners, ((0, 1, 2), (0, 2, 3))))]),
    ]
    for k in range(30):
        shapes: list[engine.Shape] = [
            engine.Sphere(0.06), engine.Box((0.06, 0.04, 0.08)), engine.Capsule(0.04, 0.06), engine.Cylinder(0.05, 0.05),
            engine.ConvexHull((0.06 * rng.normal(size=(8, 3))).tolist()),
        ]  # fmt: skip
        bodies.append(
            engine.Body(
                name=f"b{k}", inertia=0.01 * np.eye(3), shapes=[engine.Placed(shapes[k % 5])], q_WB=rng.normal(size=4),
                p_WB=(*rng.uniform(-0.2, 0.2, 2), 0.3 + 0.08 * k), v_WB=(0, 0, -1), w_WB=rng.normal(size=3),
            )
        )  # fmt: skip
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.4)
    return engine.World(bodies, surfaces={DEFAULT: law}, options=engine.Options(bounding_volume=volume, **options))  # type: ignore[arg-type]


@pytest.mark.parametrize("dt", [1 / 240, 1 / 60])
def test_the_bounding_volume_does_not_change_one_bit_of_the_motion(dt: float) -> None:
    """Pairs beyond those that touch get no contact, so it does not matter which of them a volume drops."""
    states = []
    for volume in BOUNDING_VOLUMES:
        world = _heap(volume, dt=dt)
        world.step(round(0.8 / dt))
        states.append(world.state().copy())
    assert np.array_equal(states[0], states[1])
    assert np.array_equal(states[0], states[2])


def test_only_the_chosen_volume_is_loaded(fork: Fork) -> None:
    """A module that is not imported is not compiled; the axis-aligned box needs none."""
    program = (
        "import sys, engine\n"
        "ball = engine.Placed(engine.Sphere(0.1))\n"
        "bodies = [engine.Body(name=str(k), shapes=[ball], p_WB=(k, 0, 0)) for k in range(2)]\n"
        "for volume in ('aabb', 'sphere'):\n"
        "    engine.World(bodies, options=engine.Options(bounding_volume=volume))\n"
        "    print([name for name in ('obb', 'sphere') if 'plumbline.engine.broad.volumes.' + name in sys.modules])\n"
    )
    assert fork(program).split("\n")[:2] == ["[]", "['sphere']"]


def test_an_unknown_volume_is_refused() -> None:
    with pytest.raises(ValueError, match="bounding_volume 'kdop', expected one of aabb, obb, sphere"):
        engine.Options(bounding_volume="kdop")


def test_the_adapter_resolves_broad_phase_volume_and_threads() -> None:
    """By default as the engine chose them, else as asked."""
    from plumbline.adapters.reference import ADAPTER
    from plumbline.harness.adapter import Settings
    from plumbline.harness.scene import Body, PlacedShape, Plane, Scene, Sphere, Surface

    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    for number, chosen in ((2, "brute_force"), (40, "uniform_grid")):
        ball = (PlacedShape(shape=Sphere(radius=0.1)),)
        bodies = (Body(name=f"b{k}", collision=ball, p_WB=(float(k), 0.0, 1.0)) for k in range(number))
        scene = Scene(bodies=(ground, *bodies), surfaces=(Surface(),))
        used = ADAPTER.build(scene, Settings()).resolved.options
        assert (used["broad_phase"], used["bounding_volume"], used["threads"]) == (chosen, "aabb", 1)
        asked = {"broad_phase": "bvh", "bounding_volume": "obb", "threads": 2}
        resolved = ADAPTER.build(scene, Settings(options=asked)).resolved.options
        assert {name: resolved[name] for name in asked} == asked
