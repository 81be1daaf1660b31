"""Sweeps by colours and at once: what one colour holds, which orders show, the same bits on any number of threads, one rest."""

from pathlib import Path

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.arena import int_table
from tests.forks import Fork

GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
AXES = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def ball(name: str, place: object, radius: float = 0.1) -> engine.Body:
    """A ball of the density that gives one of .1 m a kilogram."""
    mass = 1e3 * radius**3
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    shapes = [engine.Placed(engine.Sphere(radius))]
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=shapes, p_WB=tuple(np.asarray(place)))


def box(name: str, place: object) -> engine.Body:
    """A cube of .2 m and a kilogram."""
    shapes = [engine.Placed(engine.Box((0.1, 0.1, 0.1)))]
    return engine.Body(name=name, inertia=0.04 / 6 * np.eye(3), shapes=shapes, p_WB=tuple(np.asarray(place)))


def heap(
    kind: str, restitution: float = 0.0, gravity: float = -9.81, lift: float = 0.0, sweeps: str = "coloured", **options: object
) -> engine.World:
    """Some hundred bodies in touch: spheres, boxes, spheres about a large one, or a line of spheres along an axis."""
    rng = np.random.default_rng(7)
    bodies = [GROUND]
    if kind in ("spheres", "boxes", "about a large one"):
        make = box if kind == "boxes" else ball
        for k, cell in enumerate(np.ndindex(7, 4, 4)):
            place = np.array(cell) * 0.2 + (0, 0, 0.1 + lift) + rng.uniform(-0.002, 0.002, 3)
            if kind != "about a large one" or np.linalg.norm(place - (0.6, 0.3, 0.35)) > 0.39:
                bodies.append(make(f"b{k}", place))
        if kind == "about a large one":
            bodies.append(ball("large", (0.6, 0.3, 0.35), 0.3))
    else:
        axis = AXES["xyz".index(kind)]
        bodies = [ball(f"b{k}", 0.199 * k * np.array(axis)) for k in range(40)]
    law = engine.Surface(static_friction=0.6, kinetic_friction=0.5, restitution=restitution)
    return engine.World(
        bodies, [], {("default", "default"): law}, gravity=(0.0, 0.0, gravity),
        options=engine.Options(sweeps=sweeps, **options),  # type: ignore[arg-type]
    )  # fmt: skip


def contacts_by_band(world: engine.World) -> list[list[list[set[int]]]]:
    """For each colour and band, which bodies that move each contact of the last step has."""
    ints = world._ints
    count = int_table(ints, at.COUNT)[0, at.MANIFOLDS]
    key, first = (at.TOUCH_KEY, at.K_BODY_A) if world.spheres else (at.MANIFOLD_KEY, at.BODY_A)
    ends = int_table(ints, key)[:count, first : first + 2]
    moves = int_table(ints, at.BODY_KIND)[:, at.MOTION] == at.DYNAMIC
    start = int_table(ints, at.BANDS)[:, at.FIRST_IN_BAND]
    assert start[0] == 0
    assert start[-1] == count
    bands = [[{int(b) for b in row if moves[b]} for row in ends[start[k] : start[k + 1]]] for k in range(len(start) - 1)]
    return [bands[c * at.MOST_BANDS : (c + 1) * at.MOST_BANDS] for c in range(at.COLOURS)]


@pytest.mark.parametrize(("kind", "least"), [
    ("spheres", 4), ("boxes", 4), ("about a large one", 1), ("x", 20), ("y", 20), ("z", 20),
])  # fmt: skip
def test_bands_of_a_colour_move_no_common_body(kind: str, least: int) -> None:
    """Every contact is in one of them; a line of 40 along any axis is cut into many."""
    world = heap(kind)
    for _ in range(3):
        world.step(8)
        colours = contacts_by_band(world)
        assert sum(bool(band) for colour in colours for band in colour) >= least
        for colour in colours:
            moved = [set().union(*band) if band else set() for band in colour]
            for k, one in enumerate(moved):
                assert not any(one & other for other in moved[k + 1 :])


THREADS = """
import hashlib, sys
sys.path.insert(0, {folder!r})
from test_engine_sweeps import heap
for threads in (1, 2, 3, 4):
    world = heap({kind!r}, 0.4, sweeps={sweeps!r}, threads=threads)
    world.step({steps})
    print(hashlib.sha256(world.state().tobytes() + world.contacts().force.tobytes()).hexdigest())
"""


@pytest.mark.timeout(1200)
@pytest.mark.compiler
@pytest.mark.parametrize(("kind", "sweeps", "steps"), [
    ("spheres", "coloured", 60), ("boxes", "coloured", 30), ("boxes", "jacobi", 30),
    *(pytest.param(kind, "coloured", 500, marks=pytest.mark.slow) for kind in ("spheres", "boxes", "z")),
    *(pytest.param(kind, "jacobi", 300, marks=pytest.mark.slow) for kind in ("spheres", "boxes", "z")),
])  # fmt: skip
def test_one_heap_ends_with_the_same_bits_on_any_number_of_threads(kind: str, sweeps: str, steps: int, fork: Fork) -> None:
    """All of it is one island: what threads share is its sweeps. Surfaces rub and bounce."""
    said = fork(THREADS.format(folder=str(Path(__file__).parent), kind=kind, sweeps=sweeps, steps=steps)).split()
    assert len(said) == 4
    assert len(set(said)) == 1


@pytest.mark.parametrize("sweeps", ["coloured", "jacobi"])
@pytest.mark.parametrize("kind", ["spheres", "boxes"])
def test_momentum_is_kept_to_rounding(kind: str, sweeps: str) -> None:
    """Without weight, in the air: overlaps push bodies apart, each impulse on two of them."""
    world = heap(kind, gravity=0.0, lift=1.0, sweeps=sweeps)
    world.step(30)
    speeds = world.state()[1:, at.V : at.V + 3]
    assert np.abs(speeds).max() > 1e-4
    assert np.abs(speeds.sum(axis=0)).max() < 1e-13 * len(speeds) * np.abs(speeds).max()


TEN = 0.1 + 0.2 * np.arange(10)
"""Heights [m] of the boxes of a tower."""


@pytest.mark.parametrize(("sweeps", "parts"), [("coloured", 1), ("jacobi", 8)])
def test_a_tower_stands_as_it_does_by_gauss_seidel(sweeps: str, parts: int) -> None:
    """Ten boxes in bands of one each lie as deep, press as much on the ground, and are as quiet within a factor of two.

    At once, each box but the topmost counts as eight of an eighth, whose springs are eight times as soft.
    """
    towers = [
        engine.World([GROUND, *(box(f"b{k}", (0.0, 0.0, z)) for k, z in enumerate(TEN))], options=engine.Options(sweeps=one))
        for one in ("gauss_seidel", sweeps)
    ]
    for tower in towers:
        tower.step(480)
    sunk = [(TEN - tower.state()[1:, 2])[:-1] for tower in towers]
    assert sunk[1] == pytest.approx(parts * sunk[0], abs=parts * 1e-6)
    still = [np.abs(tower.state()[1:, at.V : at.W + 3]).max() for tower in towers]
    assert still[1] < 2 * still[0]
    below = [tower.contacts().force[np.any(tower.contacts().bodies == 0, axis=1)][:, 2].sum() for tower in towers]
    assert np.abs(below) == pytest.approx(98.1, rel=1e-3)


def shuffle(world: engine.World, seed: int) -> engine.World:
    """The world with the pairs of each step in an order drawn at random, and so its contacts."""
    rng = np.random.default_rng(seed)

    def sort(_floats: object, ints: object) -> None:
        pairs = int_table(ints, at.PAIR)  # type: ignore[arg-type]
        found = pairs[: int_table(ints, at.COUNT)[0, at.PAIRS]]  # type: ignore[arg-type]
        found[:] = rng.permutation(found)

    world._sort_pairs = sort
    return world


@pytest.mark.parametrize("kind", ["spheres", "boxes"])
def test_at_once_no_order_of_contacts_shows(kind: str) -> None:
    """In any order a heap is where it is after ten steps, to the rounding of its metre; by Gauss-Seidel it is elsewhere."""
    apart = {}
    for sweeps in ("gauss_seidel", "jacobi"):
        worlds = [heap(kind, sweeps=sweeps, broad_phase="uniform_grid") for _ in range(2)]
        shuffle(worlds[1], 3)
        for world in worlds:
            world.step(10)
        apart[sweeps] = np.abs(worlds[0].state() - worlds[1].state())[:, : at.P + 3].max()
    assert apart["jacobi"] < 1e-14
    assert apart["gauss_seidel"] > 1e-7


def wall(sweeps: str) -> engine.World:
    """A pyramid of 21 boxes in six rows, the same to the left and to the right."""
    places = [((k - (5 - row) / 2) * 0.22, 0.0, 0.1 + 0.2 * row) for row in range(6) for k in range(6 - row)]
    return engine.World(
        [GROUND, *(box(f"b{k}", place) for k, place in enumerate(places))], options=engine.Options(sweeps=sweeps)
    )


def test_at_once_what_is_alike_on_both_sides_stays_so() -> None:
    """Left and right of a pyramid stay mirror images to rounding, where Gauss-Seidel moves them apart by microns."""
    odd = {}
    for sweeps in ("gauss_seidel", "jacobi"):
        world = wall(sweeps)
        start = world.state()[1:, 0]
        rows = world.state()[1:, 2]
        twin = [int(np.argmin(np.abs(start + x) + np.abs(rows - z))) for x, z in zip(start, rows, strict=True)]
        world.step(240)
        x, z = world.state()[1:, 0], world.state()[1:, 2]
        odd[sweeps] = max(np.abs(x + x[twin]).max(), np.abs(z - z[twin]).max())
    assert odd["jacobi"] < 1e-14
    assert odd["gauss_seidel"] > 1e-6


def test_at_once_legs_share_alike() -> None:
    """A slab on six equal blocks in two rows: the four at the corners bear the same, and so do the two between them."""
    blocks = [box(f"b{k}", ((k % 3 - 1) * 0.4, (k // 3 - 0.5) * 0.4, 0.1)) for k in range(6)]
    shapes = [engine.Placed(engine.Box((0.6, 0.4, 0.05)))]
    inertia = 10 / 3 * np.diag([0.4**2 + 0.05**2, 0.6**2 + 0.05**2, 0.6**2 + 0.4**2])
    slab = engine.Body(name="slab", mass=10.0, inertia=inertia, shapes=shapes, p_WB=(0.0, 0.0, 0.25))
    spread = {}
    for sweeps in ("gauss_seidel", "jacobi"):
        world = engine.World([GROUND, *blocks, slab], options=engine.Options(sweeps=sweeps))
        world.step(480)
        contacts = world.contacts()
        loads = np.array([
            np.abs(contacts.force[np.all(np.sort(contacts.bodies, axis=1) == (1 + k, 7), axis=1), 2].sum()) for k in range(6)
        ])  # fmt: skip
        assert loads.sum() == pytest.approx(98.1, rel=1e-6)
        spread[sweeps] = max(np.ptp(loads[[0, 2, 3, 5]]), np.ptp(loads[[1, 4]]))
    assert spread["jacobi"] < 1e-9
    assert spread["gauss_seidel"] > 1e-6


@pytest.mark.parametrize("friction", ["rolling_friction", "torsional_friction"])
def test_at_once_friction_against_turning_stops_a_ball(friction: str) -> None:
    """It has a part of the ball of its own; what remains is what friction in any order leaves."""
    end = {}
    for sweeps in ("gauss_seidel", "jacobi"):
        spinning = engine.Body(
            name="ball", inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0.0, 0.0, 0.1),
            v_WB=(0.5, 0.0, 0.0) if friction == "rolling_friction" else (0.0, 0.0, 0.0),
            w_WB=(0.0, 5.0, 0.0) if friction == "rolling_friction" else (0.0, 0.0, 5.0),
        )  # fmt: skip
        law = engine.Surface(static_friction=0.6, kinetic_friction=0.6, **{friction: 0.005})
        world = engine.World([GROUND, spinning], [], {("default", "default"): law}, options=engine.Options(sweeps=sweeps))
        world.step(48)
        end[sweeps] = world.state()[1, at.W : at.W + 3]
    assert 0.5 < np.linalg.norm(end["gauss_seidel"]) < 4.9
    assert end["jacobi"] == pytest.approx(end["gauss_seidel"], rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("sweeps", ["coloured", "jacobi"])
def test_a_batch_has_gauss_seidel_alone(sweeps: str) -> None:
    with pytest.raises(engine.NotSupported, match=f"sweeps '{sweeps}'"):
        engine.Batch.replicate(heap("x", sweeps=sweeps), 2)


@pytest.mark.parametrize("sweeps", ["coloured", "jacobi"])
@pytest.mark.parametrize(
    "options", [{"solver": "exact"}, {"solver": "sequential_impulses"}, {"sleeping": True}, {"continuous": "swept"}]
)
def test_what_knows_gauss_seidel_alone_says_so(options: dict[str, object], sweeps: str) -> None:
    with pytest.raises(engine.NotSupported, match=f"sweeps '{sweeps}'"):
        heap("x", sweeps=sweeps, **options)


@pytest.mark.parametrize("sweeps", ["coloured", "jacobi"])
def test_joints_know_gauss_seidel_alone(sweeps: str) -> None:
    tie = engine.Ball(name="tie", parent="a", child="b", anchor_W=(0.1, 0.0, 1.0))
    bodies = [GROUND, ball("a", (0.0, 0.0, 1.0)), ball("b", (0.2, 0.0, 1.0))]
    with pytest.raises(engine.NotSupported, match=f"sweeps '{sweeps}'"):
        engine.World(bodies, [tie], options=engine.Options(sweeps=sweeps))


def test_an_unknown_sweep_is_named() -> None:
    with pytest.raises(ValueError, match="sweeps 'twice', expected one of gauss_seidel, coloured, jacobi"):
        engine.Options(sweeps="twice")
