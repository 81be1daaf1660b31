"""Islands: connected components as another program finds them, and solved on threads with the same bits."""

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components as scipy_components

from plumbline import engine
from plumbline.engine.build.assembly import wants_islands
from plumbline.engine.memory import arena as at
from plumbline.engine.steps.contact_jointed import step_contact_jointed
from tests.engine_entries import connected_components
from tests.forks import Fork

GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])


def islands_of(links: np.ndarray, movable: np.ndarray) -> tuple[int, np.ndarray]:
    """How many islands there are, and that of each body."""
    kind = np.zeros((len(movable), 4), np.int64)
    kind[:, at.MOTION] = np.where(movable, at.DYNAMIC, at.STATIC)
    island = np.zeros((len(movable), 8), np.int64)
    return int(connected_components(np.asarray(links, np.int64).reshape(-1, 2), kind, island)), island[:, at.NUMBER]


def test_islands_by_hand() -> None:
    """0-2 and 4-5 touch; 1 is alone; 3 is the ground, on which 2 and 4 stand without being joined by it."""
    count, number = islands_of(np.array([[2, 0], [3, 2], [4, 3], [5, 4]]), np.array([True, True, True, False, True, True]))
    assert count == 3
    assert number.tolist() == [0, 1, 0, -1, 2, 2]


@pytest.mark.parametrize("links", [0, 40, 90, 140, 400])
def test_islands_are_the_connected_components_that_scipy_finds(links: int) -> None:
    """Random graphs from many islands to one; a quarter of the bodies is fixed and joins nothing."""
    rng = np.random.default_rng(links)
    for _ in range(20):
        movable = rng.random(120) < 0.75
        pairs = rng.integers(0, 120, (links, 2))
        count, number = islands_of(pairs, movable)
        both = pairs[movable[pairs].all(axis=1)]
        graph = coo_array((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(120, 120))
        _, label = scipy_components(graph, directed=False)
        assert (number[~movable] == -1).all()
        same = number[movable][:, None] == number[movable][None, :]
        assert np.array_equal(same, label[movable][:, None] == label[movable][None, :])
        lowest = [np.flatnonzero(number == i)[0] for i in range(count)]
        assert lowest == sorted(lowest)


def stacks(count: int, restitution: float = 0.0, tied: bool = False, **options: object) -> engine.World:
    """`count` stacks of two boxes and a ball, set down a little askew; where tied, ball and upper box hang together."""
    inertia, bodies, joints = 0.04 / 6 * np.eye(3), [GROUND], []
    for i in range(count):
        for k in range(3):
            shape = engine.Sphere(0.1) if k == 2 else engine.Box((0.1, 0.1, 0.1))
            place = (0.5 * i + 0.01 * k, 0.003 * i * k, 0.1 + 0.2 * k + 0.001 * i * (k + 1))
            bodies.append(engine.Body(name=f"{i}-{k}", inertia=inertia, shapes=[engine.Placed(shape)], p_WB=place))
        if tied:
            tie = engine.Distance(
                name=f"tie {i}", parent=f"{i}-1", child=f"{i}-2", anchor_W=tuple(bodies[-2].p_WB),
                child_anchor_W=tuple(bodies[-1].p_WB),
            )  # fmt: skip
            joints.append(tie)
    law = engine.Surface(static_friction=0.6, kinetic_friction=0.5, restitution=restitution)
    return engine.World(bodies, joints, {("default", "default"): law}, options=engine.Options(**options))  # type: ignore[arg-type]


@pytest.mark.timeout(1200)
@pytest.mark.parametrize("tied", [False, True])
@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_islands_solved_apart_end_with_the_bits_of_all_solved_together(restitution: float, tied: bool) -> None:
    """Islands share no body that moves, so the order in which they are swept cannot matter; none has time to sleep here."""
    together, apart = stacks(6, restitution, tied), stacks(6, restitution, tied, sleeping=True, sleep_time=1e6)
    if tied:
        # Left to itself, a world of six machines is solved island by island as well.
        together._step = step_contact_jointed
    together.step(200)
    apart.step(200)
    assert np.array_equal(together.state(), apart.state())
    for name in ("bodies", "point", "normal", "gap", "force"):
        assert np.array_equal(getattr(together.contacts(), name), getattr(apart.contacts(), name))


def rod(parent: str, child: str) -> engine.Ball:
    """A joint between two bodies."""
    return engine.Ball(name=f"{parent}-{child}", parent=parent, child=child, anchor_W=(0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("joints", "machines"),
    [
        ([], 0),
        ([("a", "b"), ("b", "c"), ("c", "d")], 1),
        ([("a", "b"), ("c", "d")], 2),
        ([("a", "b"), ("c", "d"), ("b", "c")], 1),
        ([("a", "b"), ("b", "c"), ("c", "a")], 1),
        ([("ground", "a"), ("ground", "b")], 2),
        ([("world", "a"), ("world", "b"), ("a", "b")], 1),
        ([("world", "a"), ("ground", "a")], 1),
    ],
)
def test_more_machines_than_one_are_solved_apart(joints: list[tuple[str, str]], machines: int) -> None:
    """The ground and the world join nothing; a loop counts once."""
    bodies = [GROUND, *(engine.Body(name=name) for name in "abcd")]
    made = [rod(*ends) for ends in joints]
    assert wants_islands(bodies, made, engine.Options()) is (machines > 1)
    assert not wants_islands(bodies, made, engine.Options(solver="exact"))
    assert wants_islands(bodies, [], engine.Options(threads=2))


THREADS = """
import hashlib, sys
sys.path.insert(0, {folder!r})
from test_engine_islands import stacks
for threads in (1, 2, 4):
    world = stacks(30, {restitution}, {tied}, threads=threads)
    world.step({steps})
    print(hashlib.sha256(world.state().tobytes() + world.contacts().force.tobytes()).hexdigest())
"""


@pytest.mark.timeout(1200)
@pytest.mark.compiler
@pytest.mark.parametrize(
    ("restitution", "tied", "steps"),
    [
        (0.4, False, 150),
        *(pytest.param(*slow, 500, marks=pytest.mark.slow) for slow in ((0.4, False), (0.0, False), (0.4, True))),
    ],
)
def test_thirty_stacks_end_with_the_same_bits_on_one_two_and_four_threads(
    restitution: float, tied: bool, steps: int, fork: Fork
) -> None:
    """Four threads exist in a process that is told so, however many cores there are."""
    said = fork(THREADS.format(folder=str(Path(__file__).parent), restitution=restitution, tied=tied, steps=steps)).split()
    assert len(said) == 3
    assert len(set(said)) == 1


def test_one_thread_compiles_nothing_parallel(fork: Fork) -> None:
    """A world of one thread never loads the module of islands."""
    late = "plumbline.engine.steps.islands"
    code = f"import sys; from test_engine_islands import stacks; stacks(1).step(0); print({late!r} in sys.modules)"
    assert fork(f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); {code}").split() == ["False"]


def test_options_of_islands_are_checked() -> None:
    with pytest.raises(ValueError, match="threads 0, expected a whole number of at least 1"):
        engine.Options(threads=0)
    with pytest.raises(ValueError, match=r"sleep_speed 0.0 m/s"):
        engine.Options(sleep_speed=0.0)
    with pytest.raises(ValueError, match=r"sleep_time -1.0 s"):
        engine.Options(sleep_time=-1.0)
    with pytest.raises(engine.NotSupported, match="sleep"):
        stacks(1, solver="exact", sleeping=True)
