"""Sweeps by colours: what one colour holds, the same bits for any number of threads, and the same rest as without."""

from pathlib import Path

import numpy as np
import pytest

import engine
from engine.memory import arena as at
from engine.memory.arena import int_table
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


def heap(kind: str, restitution: float = 0.0, gravity: float = -9.81, lift: float = 0.0, **options: object) -> engine.World:
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
        options=engine.Options(coloured=True, **options),  # type: ignore[arg-type]
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
from test_engine_colours import heap
for threads in (1, 2, 3, 4):
    world = heap({kind!r}, 0.4, threads=threads)
    world.step({steps})
    print(hashlib.sha256(world.state().tobytes() + world.contacts().force.tobytes()).hexdigest())
"""


@pytest.mark.timeout(1200)
@pytest.mark.compiler
@pytest.mark.parametrize(("kind", "steps"), [
    ("spheres", 60), ("boxes", 30), *(pytest.param(kind, 500, marks=pytest.mark.slow) for kind in ("spheres", "boxes", "z")),
])  # fmt: skip
def test_one_heap_ends_with_the_same_bits_on_any_number_of_threads(kind: str, steps: int, fork: Fork) -> None:
    """All of it is one island: what threads share is its sweeps. Surfaces rub and bounce."""
    said = fork(THREADS.format(folder=str(Path(__file__).parent), kind=kind, steps=steps)).split()
    assert len(said) == 4
    assert len(set(said)) == 1


@pytest.mark.parametrize("kind", ["spheres", "boxes"])
def test_momentum_is_kept_to_rounding(kind: str) -> None:
    """Without weight, in the air: overlaps push bodies apart, each impulse on two of them."""
    world = heap(kind, gravity=0.0, lift=1.0)
    world.step(30)
    speeds = world.state()[1:, at.V : at.V + 3]
    assert np.abs(speeds).max() > 1e-4
    assert np.abs(speeds.sum(axis=0)).max() < 1e-13 * len(speeds) * np.abs(speeds).max()


def test_a_tower_stands_as_it_does_without_colours() -> None:
    """Ten boxes in bands of one each lie as deep, press as much on the ground, and are as quiet within a factor of two."""
    towers = [
        engine.World(
            [GROUND, *(box(f"b{k}", (0.0, 0.0, 0.1 + 0.2 * k)) for k in range(10))], options=engine.Options(coloured=coloured)
        )
        for coloured in (False, True)
    ]
    for tower in towers:
        tower.step(480)
    heights = [tower.state()[1:, 2] for tower in towers]
    assert heights[1] == pytest.approx(heights[0], abs=1e-5)
    still = [np.abs(tower.state()[1:, at.V : at.W + 3]).max() for tower in towers]
    assert still[1] < 2 * still[0]
    below = [tower.contacts().force[np.any(tower.contacts().bodies == 0, axis=1)][:, 2].sum() for tower in towers]
    assert np.abs(below) == pytest.approx(98.1, rel=1e-3)


def test_a_batch_has_no_colours() -> None:
    with pytest.raises(engine.NotSupported, match="sweeps by colours"):
        engine.Batch.replicate(heap("x"), 2)


@pytest.mark.parametrize(
    "options", [{"solver": "exact"}, {"solver": "sequential_impulses"}, {"sleeping": True}, {"continuous": "swept"}]
)
def test_what_knows_no_colours_says_so(options: dict[str, object]) -> None:
    with pytest.raises(engine.NotSupported, match="sweeps by colours"):
        heap("x", **options)


def test_joints_know_no_colours() -> None:
    tie = engine.Ball(name="tie", parent="a", child="b", anchor_W=(0.1, 0.0, 1.0))
    bodies = [GROUND, ball("a", (0.0, 0.0, 1.0)), ball("b", (0.2, 0.0, 1.0))]
    with pytest.raises(engine.NotSupported, match="sweeps by colours"):
        engine.World(bodies, [tie], options=engine.Options(coloured=True))
