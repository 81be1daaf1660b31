"""Broad phases: all find the pairs that testing every pair finds, in one order, whatever the shapes."""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from plumbline import engine
from plumbline.engine.articulated.assembly import grow_world
from plumbline.engine.broad.bounds import BLOCK
from plumbline.engine.broad.choice import FEW, choose_broad_phase
from plumbline.engine.build.assembly import grow
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.arena import float_table, int_table
from plumbline.engine.memory.status import FULL
from plumbline.engine.options import BROAD_PHASES
from tests.forks import Fork

pytestmark = pytest.mark.usefixtures("solids_found_once")

Motion = Literal["dynamic", "static", "kinematic"]

DEFAULT = ("default", "default")
MOTIONS: tuple[Motion, ...] = ("dynamic", "dynamic", "dynamic", "static", "kinematic")
STANDING: tuple[Motion, ...] = ("static", "static", "static", "static", "dynamic")
R = 0.05
OCTAHEDRON = engine.ConvexHull(
    [(sign * R * (k == 0), sign * R * (k == 1), sign * R * (k == 2)) for k in range(3) for sign in (-1, 1)]
)
CLOUD = np.random.default_rng(8).normal(size=(8, 3))
"""The corners [1] of a hull without symmetry."""
SEARCHES = tuple(name for name in BROAD_PHASES if name != "brute_force")


def _random_bodies(
    seed: int, number: int, spread: float, ratio: float, planes: int, motions: tuple[Motion, ...] = MOTIONS
) -> list[engine.Body]:
    """Bodies of all shapes, sizes spread over `ratio`, some static, some kinematic, some of two shapes, many touching."""
    rng = np.random.default_rng(seed)
    bodies = []
    for i in range(number):
        r = 0.05 * ratio ** rng.uniform()
        made: list[Callable[[], engine.Shape]] = [
            lambda r=r: engine.Sphere(r),
            lambda r=r: engine.Box((r, r * rng.uniform(0.1, 1), r)),
            lambda r=r: engine.Capsule(r, r * rng.uniform(0.1, 5)),
            lambda r=r: engine.Cylinder(r, r * rng.uniform(0.1, 5)),
            # One of few hulls, whose faces are found once: a search sees no more of a shape than its bounds.
            lambda r=r: engine.ConvexHull(2.0 ** round(math.log2(r)) * CLOUD),
            lambda r=r: engine.TriangleMesh(r * rng.normal(size=(4, 3)), ((0, 1, 2), (0, 2, 3))),
        ]
        motion = motions[int(rng.integers(5))]
        q = rng.normal(size=4)
        places, kinds = r * rng.normal(size=(2, 3)), rng.integers(5 + (motion != "dynamic"), size=rng.integers(1, 3))
        placed = [engine.Placed(made[k](), p_BS=tuple(p), q_BS=tuple(q)) for k, p in zip(kinds, places, strict=False)]
        velocity = tuple(rng.normal(size=3)) if motion != "static" else (0.0, 0.0, 0.0)
        bodies.append(
            engine.Body(
                name=f"b{i}", shapes=placed, motion=motion, material=("default", "other")[int(rng.integers(2))],
                p_WB=tuple(spread * rng.normal(size=3)), q_WB=tuple(rng.normal(size=4)), v_WB=velocity, w_WB=velocity,
            )
        )  # fmt: skip
    for k in range(planes):
        shape = engine.Placed(engine.Plane(tuple(rng.normal(size=3))))
        moving: Motion = "kinematic" if k % 2 else "static"
        bodies.insert(
            int(rng.integers(len(bodies) + 1)),
            engine.Body(name=f"plane{k}", shapes=[shape], motion=moving, v_WB=(0, 0, 0.3) if k % 2 else (0, 0, 0)),
        )
    return bodies


def _found(world: engine.World) -> list[tuple[int, int]]:
    """The pairs that a world's search finds at its present state."""
    assert world._find_pairs is not None
    for _ in range(20):
        if world._find_pairs(world._floats, world._ints) == 0:
            number = int_table(world._ints, at.COUNT)[0, at.PAIRS]
            return [(int(i), int(j)) for i, j in int_table(world._ints, at.PAIR)[:number]]
        world._floats, world._ints = grow(world._floats, world._ints)
    raise AssertionError("no room after twenty times twice as much")


@pytest.mark.parametrize("name", SEARCHES)
def test_a_world_makes_room_once_for_all_pairs_that_it_meets(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred boxes in one place: 4950 pairs, six times as many as there is room for at first."""
    grown: list[int] = []

    def counted(*given: Any) -> Any:
        grown.append(len(int_table(given[1], at.PAIR)))
        return grow_world(*given)

    monkeypatch.setattr(engine.world, "grow_world", counted)
    bodies = [engine.Body(name=f"b{k}", shapes=[engine.Placed(engine.Box((1.0, 1.0, 1.0)))]) for k in range(100)]
    world = engine.World(bodies, options=engine.Options(broad_phase=name))
    while world._search() == FULL:
        world._resume(FULL)
    assert len(grown) == 1
    assert 4 * grown[0] < 4950 <= len(int_table(world._ints, at.PAIR))


def _worlds(bodies: list[engine.Body], names: tuple[str, ...], **options: object) -> list[engine.World]:
    apart = [("other", "other")]
    return [engine.World(bodies, apart=apart, options=engine.Options(broad_phase=name, **options)) for name in names]  # type: ignore[arg-type]


CROWDS = given(
    seed=st.integers(0, 2**32 - 1),
    number=st.integers(FEW, 90),
    spread=st.sampled_from([0.0, 1e-3, 0.1, 0.5, 3.0, 1e3, 1e9]),
    ratio=st.sampled_from([1.0, 3.0, 100.0, 1e5]),
    planes=st.integers(0, 3),
    motions=st.sampled_from([MOTIONS, STANDING]),
)


@settings(max_examples=4, deadline=None)
@CROWDS
def test_every_search_finds_what_testing_all_pairs_finds(
    seed: int, number: int, spread: float, ratio: float, planes: int, motions: tuple[Motion, ...]
) -> None:
    """The lists are equal, order included; so they are after bodies have moved, a little or far, since the last search."""
    _all_find_the_same(seed, number, spread, ratio, planes, motions)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@CROWDS
def test_every_search_finds_what_testing_all_pairs_finds_in_two_hundred_crowds(
    seed: int, number: int, spread: float, ratio: float, planes: int, motions: tuple[Motion, ...]
) -> None:
    _all_find_the_same(seed, number, spread, ratio, planes, motions)


def _all_find_the_same(seed: int, number: int, spread: float, ratio: float, planes: int, motions: tuple[Motion, ...]) -> None:
    bodies = _random_bodies(seed, number + 1, spread, ratio, planes, motions)
    movable = [i for i, body in enumerate(bodies) if body.motion == "dynamic"]
    assume(movable)  # Where nothing can move nothing is searched.
    oracle, *others = _worlds(bodies, ("brute_force", *SEARCHES))
    rng = np.random.default_rng(seed)
    # Steps of another length widen all bounds; and at last whoever writes states moves what stands still too.
    for move, moved, dt in (
        (0.0, movable, 1 / 60),
        (1e-3, movable, 1 / 60),
        (1e-2, movable, 1 / 30),
        (1.0, movable, 1 / 960),
        (0.1, list(range(len(bodies))), 1 / 960),
    ):
        step = move * rng.normal(size=(len(moved), 3))
        for world in (oracle, *others):
            world.state()[moved, :3] += step
            world.retime(dt)
        expected = _found(oracle)
        assert expected == sorted(set(expected), key=lambda pair: (pair[0] // BLOCK, pair[1] - pair[0], pair[0]))
        for world in others:
            assert _found(world) == expected, world.broad_phase
    (new,) = _worlds(bodies, ("brute_force",))
    new.state()[:] = oracle.state()
    new.retime(dt)
    assert _found(new) == expected


OVERLAPS = given(seed=st.integers(0, 2**32 - 1), spread=st.sampled_from([0.1, 0.5, 3.0]), planes=st.integers(0, 2))


@settings(max_examples=6, deadline=None)
@OVERLAPS
def test_the_pairs_are_those_of_overlapping_bounds(seed: int, spread: float, planes: int) -> None:
    """Against a comparison of the boxes written out here."""
    _pairs_are_those_of_bounds(seed, spread, planes)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@OVERLAPS
def test_the_pairs_are_those_of_overlapping_bounds_in_forty_crowds(seed: int, spread: float, planes: int) -> None:
    _pairs_are_those_of_bounds(seed, spread, planes)


def _pairs_are_those_of_bounds(seed: int, spread: float, planes: int) -> None:
    bodies = _random_bodies(seed, FEW + 10, spread, 10.0, planes)
    (world,) = _worlds(bodies, ("bvh",))
    found = set(_found(world))
    bounds, kind = float_table(world._floats, world._ints, at.BOUNDS), int_table(world._ints, at.SHAPE_KIND)
    for i in range(len(kind)):
        for j in range(i + 1, len(kind)):
            one, two = bodies[kind[i, at.OWNER]], bodies[kind[j, at.OWNER]]
            never = one is two or "dynamic" not in (one.motion, two.motion) or one.material == two.material == "other"
            if never:
                assert (i, j) not in found
            elif at.PLANE not in (kind[i, at.TYPE], kind[j, at.TYPE]):
                boxes = np.all(bounds[i, :3] <= bounds[j, 3:6]) and np.all(bounds[j, :3] <= bounds[i, 3:6])
                assert ((i, j) in found) == boxes


def _pile(number: int, broad_phase: str | None, first: engine.Shape | None = None, threads: int = 1) -> engine.World:
    """Balls, the first of them replaced by another shape if one is given, that fall onto a plane within four static slabs."""
    rng, r = np.random.default_rng(7), R
    bodies = [engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])]
    for sign in (-1, 1):
        for name, half, spot in (("x", (0.1, 1, 3), (0.35 * sign, 0, 3)), ("y", (1, 0.1, 3), (0, 0.35 * sign, 3))):
            wall = engine.Placed(engine.Box(half))
            bodies.append(engine.Body(name=f"{name}{sign}", motion="static", shapes=[wall], p_WB=spot))
    for i in range(number):
        shape = engine.Placed(first if first is not None and i == 0 else engine.Sphere(r))
        place = np.array([i % 4 - 1.5, i // 4 % 4 - 1.5, i // 16 + 0.5]) * 0.12 + rng.uniform(-0.01, 0.01, 3)
        bodies.append(engine.Body(name=f"s{i}", inertia=0.4 * r * r * np.eye(3), shapes=[shape], p_WB=place))
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.4, restitution=0.2)
    return engine.World(bodies, surfaces={DEFAULT: law}, options=engine.Options(broad_phase=broad_phase, threads=threads))


@pytest.mark.parametrize(
    "first",
    [
        pytest.param(None, id="spheres"),
        pytest.param(engine.Box((R, R, R)), id="box"),
        pytest.param(OCTAHEDRON, id="hull", marks=pytest.mark.slow),
    ],
)
def test_the_broad_phase_does_not_change_one_bit_of_a_pile(first: engine.Shape | None) -> None:
    """All hand over the same pairs in the same order, so all steps are the same sums."""
    states = []
    for name in BROAD_PHASES:
        world = _pile(40, name, first)
        world.step(120)
        states.append(world.state().copy())
    assert all(np.array_equal(one, two) for one, two in pairwise(states))


SPREADS = given(seed=st.integers(0, 2**32 - 1), spread=st.sampled_from([0.0, 0.5, 1e9]))


@pytest.mark.parametrize("name", BROAD_PHASES)
@settings(max_examples=2, deadline=None)
@SPREADS
def test_any_number_of_threads_finds_the_same_pairs(name: str, seed: int, spread: float) -> None:
    """Order included, in the arena's rows, from step to step, also where there are fewer shapes than threads would like."""
    _threads_agree(name, seed, spread)


@pytest.mark.slow
@pytest.mark.parametrize("name", BROAD_PHASES)
@settings(max_examples=40, deadline=None)
@SPREADS
def test_any_number_of_threads_finds_the_same_pairs_in_forty_crowds(name: str, seed: int, spread: float) -> None:
    _threads_agree(name, seed, spread)


def _threads_agree(name: str, seed: int, spread: float) -> None:
    bodies = _random_bodies(seed, 40, spread, 30.0, 1)
    worlds = [engine.World(bodies, options=engine.Options(broad_phase=name, threads=threads)) for threads in (1, 2, 4)]
    rng = np.random.default_rng(seed)
    for move in (0.0, 1e-3, 1.0):
        moved = [i for i, body in enumerate(bodies) if body.motion == "dynamic"]
        step = move * rng.normal(size=(len(moved), 3))
        found = []
        for world in worlds:
            world.state()[moved, :3] += step
            found.append(_found(world))
        assert found[0] == found[1] == found[2]


@pytest.mark.parametrize(
    "first", [pytest.param(None, id="spheres"), pytest.param(OCTAHEDRON, id="hull", marks=pytest.mark.slow)]
)
def test_any_number_of_threads_gives_the_same_bits(first: engine.Shape | None) -> None:
    states = []
    for threads in (1, 2, 4):
        world = _pile(60, None, first, threads)
        world.step(120)
        states.append(world.state().tobytes())
    assert states[0] == states[1] == states[2]


def test_a_world_of_one_thread_searches_on_no_others(fork: Fork) -> None:
    program = (
        "import engine\n"
        "ball = engine.Placed(engine.Sphere(0.1))\n"
        "bodies = [engine.Body(name=str(k), shapes=[ball], p_WB=(k, 0, 0)) for k in range(40)]\n"
        "for threads in (1, 2):\n"
        "    print(engine.World(bodies, options=engine.Options(threads=threads))._find_pairs.__name__)\n"
    )
    assert fork(program).split() == ["find_pairs", "find_pairs_parallel"]
    with pytest.raises(ValueError, match="threads 0, expected a whole number of at least 1"):
        engine.Options(threads=0)


def test_a_saved_pile_goes_on_as_if_nothing_had_been() -> None:
    """The list of candidates is part of what is saved; found at another time, it would still give the same pairs."""
    world = _pile(40, None)
    world.step(60)
    saved = world.save()
    world.step(60)
    after = world.state().copy()
    world.restore(saved)
    world.step(60)
    assert np.array_equal(world.state(), after)


def test_spheres_alone_move_as_they_do_beside_a_box_far_away() -> None:
    """The solver of spheres leaves out what is zero for them: with the general one the paths differ by rounding only.

    One ball on each spot, so that nothing multiplies a rounding error; .25 s with a bounce, sliding, rolling and rest.
    """
    r = 0.05
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    shelf = engine.Body(name="shelf", motion="static", shapes=[engine.Placed(engine.Box((1, 1, 0.1)))], p_WB=(5, 0, 0))
    ball = engine.Placed(engine.Sphere(r))
    balls = [
        engine.Body(name=f"s{k}", inertia=0.4 * r * r * np.eye(3), shapes=[ball], p_WB=p, v_WB=v, w_WB=w)
        for k, (p, v, w) in enumerate(
            [
                ((0, 0, 0.05), (2, 1, 0), (0, 3, 0)),
                ((5, 0, 0.2), (0, 1, 0), (1, 0, 9)),
                ((1, 0, 0.25), (0, 0, 0), (0, 0, 0)),
                ((5, 0.5, 0.15), (0, 0, 0), (0, 0, 0)),
            ]
        )
    ]
    box = engine.Body(name="far", shapes=[engine.Placed(engine.Box((r, r, r)))], p_WB=(1e3, 0, 5))
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.4, restitution=0.3)
    alone = engine.World([ground, shelf, *balls], surfaces={DEFAULT: law})
    beside = engine.World([ground, shelf, *balls, box], surfaces={DEFAULT: law})
    assert (alone.spheres, beside.spheres) == (True, False)
    for _ in range(60):
        alone.step()
        beside.step()
        np.testing.assert_allclose(alone.state(), beside.state()[:-1], rtol=0, atol=1e-9)
    one, two = alone.contacts(), beside.contacts()
    np.testing.assert_array_equal(one.bodies, two.bodies)
    np.testing.assert_allclose(one.normal, two.normal, atol=1e-12)
    np.testing.assert_allclose(one.force, two.force, atol=1e-6)


def test_two_spheres_that_rub_keep_their_momentum_and_angular_momentum() -> None:
    """Both arms lead to one place, so what one gains the other loses: a thousand sums of round-off size."""
    r = 0.05
    spins, sides = ((0.0, 9.0, 2.0), (3.0, -1.0, 0.0)), ((1.0, 0.1, 0.02), (-1.0, -0.1, 0.0))
    balls = [
        engine.Body(name=f"s{k}", inertia=0.4 * r * r * np.eye(3), shapes=[engine.Placed(engine.Sphere(r))],
                    p_WB=((2 * k - 1) * 0.06, 0.02 * k, 0), v_WB=sides[k], w_WB=spins[k])
        for k in range(2)
    ]  # fmt: skip
    world = engine.World(
        balls, surfaces={DEFAULT: engine.Surface(static_friction=0.6, kinetic_friction=0.5)}, gravity=(0, 0, 0)
    )

    def angular() -> np.ndarray:
        s = world.state()
        return np.asarray((np.cross(s[:, :3], s[:, 7:10]) + 0.4 * r * r * s[:, 10:]).sum(axis=0))

    before, spin = angular(), world.state()[:, 10:].copy()
    world.step(60)
    assert np.abs(world.state()[:, 10:] - spin).max() > 0.1
    assert np.abs(world.state()[:, 7:10].sum(axis=0) - (0, 0, 0.02)).max() < 1e-14
    assert np.abs(angular() - before).max() < 1e-14


def test_the_choice_follows_the_wish_and_else_the_number_of_shapes() -> None:
    assert choose_broad_phase(None, FEW) == "brute_force"
    assert choose_broad_phase(None, FEW + 1) != "brute_force"
    for name in BROAD_PHASES:
        assert choose_broad_phase(name, 1000) == name
    with pytest.raises(ValueError, match="broad_phase 'quadtree'"):
        engine.Options(broad_phase="quadtree")


def test_only_the_chosen_broad_phase_is_loaded(fork: Fork) -> None:
    """A module that is not imported is not compiled."""
    program = (
        "import sys, numpy as np, engine\n"
        "ball = engine.Placed(engine.Sphere(0.1))\n"
        "bodies = [engine.Body(name=str(k), shapes=[ball], p_WB=(k, 0, 0)) for k in range(40)]\n"
        "engine.World(bodies, options=engine.Options(broad_phase='octree'))\n"
        "names = ('uniform_grid', 'octree', 'sweep_and_prune', 'bvh', 'brute_force')\n"
        "print([name for name in names if 'plumbline.engine.broad.' + name in sys.modules])\n"
    )
    assert fork(program).strip() == "['octree']"


def test_widened_bounds_are_found_anew_only_when_left() -> None:
    """A resting pile searches once; a shape that moves by more than its skin makes the next step search again."""
    world = _pile(40, "bvh")
    _found(world)
    fat = float_table(world._floats, world._ints, at.FAT).copy()
    world.state()[5, 0] += 1e-4
    _found(world)
    assert np.array_equal(fat, float_table(world._floats, world._ints, at.FAT))
    world.state()[5, 0] += 0.02
    _found(world)
    assert not np.array_equal(fat, float_table(world._floats, world._ints, at.FAT))
    assert math.isfinite(float(np.abs(fat[1:]).max()))
