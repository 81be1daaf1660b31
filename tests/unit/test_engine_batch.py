"""Batches: each world ends with the bits it would have alone, on any number of threads."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.compile.jit import cache_directory, linker
from plumbline.engine.integrate import runge_kutta
from plumbline.engine.steps import many_worlds
from tests.forks import Fork

GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
ROUGH = {("default", "default"): engine.Surface(static_friction=0.5, kinetic_friction=0.5, restitution=0.3)}
TALL = engine.ConvexHull([(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.15, 0.15)])


def _body(name: str, shape: engine.Shape, rng: np.random.Generator, **state: object) -> engine.Body:
    q = rng.normal(size=4)
    return engine.Body(name=name, inertia=np.diag([0.01, 0.012, 0.014]), shapes=[engine.Placed(shape)], q_WB=q, **state)  # type: ignore[arg-type]


def _free(seed: int) -> engine.World:
    rng = np.random.default_rng(seed)
    return engine.World([engine.Body(inertia=np.diag([1.0, 2.0, 2.5]), w_WB=rng.normal(size=3)) for _ in range(1)])


def _chain(seed: int) -> engine.World:
    rng = np.random.default_rng(seed)
    spins = rng.normal(size=(3, 3))
    speeds = np.cumsum(np.cross(spins, (0.2, 0, 0)), axis=0)
    bodies = [engine.Body(name=f"b{k}", p_WB=(0.2 * (k + 1), 0, 0), v_WB=speeds[k], w_WB=spins[k]) for k in range(3)]
    joints = [
        engine.Ball(name=f"j{k}", parent=engine.WORLD if k == 0 else f"b{k - 1}", child=f"b{k}", anchor_W=(0.2 * k, 0, 0))
        for k in range(3)
    ]
    return engine.World(bodies, joints)


def _pile(seed: int) -> engine.World:
    """Seven spheres and boxes in one place: more pairs than an arena has room for at first."""
    rng = np.random.default_rng(seed)
    shapes: list[engine.Shape] = [engine.Sphere(0.1), engine.Box((0.1, 0.08, 0.12))]
    bodies = [_body(f"b{k}", shapes[k % 2], rng, p_WB=(*rng.uniform(-0.1, 0.1, 2), 0.2 + 0.05 * k)) for k in range(7)]
    return engine.World([GROUND, *bodies], surfaces=ROUGH)


def _hulls(seed: int) -> engine.World:
    """Shapes whose pairs the convex narrow phase has to answer."""
    rng = np.random.default_rng(seed)
    bodies = [_body(f"b{k}", TALL, rng, p_WB=(0, 0, 0.25 + 0.35 * k)) for k in range(3)]
    return engine.World([GROUND, *bodies], surfaces=ROUGH)


def _tied(seed: int) -> engine.World:
    """Two bodies on a joint that fall onto the ground."""
    rng = np.random.default_rng(seed)
    bodies = [
        engine.Body(name="one", inertia=0.01 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 0.3)),
        _body("two", engine.Box((0.1, 0.1, 0.1)), rng, p_WB=(0.4, 0, 0.3), v_WB=(0, 0.4, -0.2), w_WB=(0, 1, 2)),
    ]
    joint = engine.Ball(name="j", parent="one", child="two", anchor_W=(0.2, 0, 0.3))
    return engine.World([GROUND, *bodies], [joint], ROUGH)


def _crowd(seed: int) -> engine.World:
    """Spheres so many that their pairs are found before each step, falling into a heap."""
    rng = np.random.default_rng(seed)
    bodies = [
        _ball(f"b{k}", (*(0.21 * np.array([k % 5, k // 5 % 5]) + rng.uniform(-0.02, 0.02, 2)), 0.1 + 0.25 * (k // 25)))
        for k in range(100)
    ]
    return engine.World([GROUND, *bodies], surfaces=ROUGH)


def _ball(name: str, place: tuple[float, ...]) -> engine.Body:
    return engine.Body(name=name, inertia=0.004 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=place)


def _slanted(seed: int) -> engine.World:
    """Boxes whose pairs are compared by their oriented bounds too."""
    rng = np.random.default_rng(seed)
    bodies = [
        _body(f"b{k}", engine.Box((0.2, 0.05, 0.05)), rng, p_WB=(*rng.uniform(-0.2, 0.2, 2), 0.2 + 0.1 * k)) for k in range(7)
    ]
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(bounding_volume="obb"))


def _sleepers(seed: int) -> engine.World:
    """Boxes that have slept for a while when a ball, by one search before the step, finds the first of them."""
    boxes = [
        engine.Body(
            name=f"b{k}", inertia=0.006 * np.eye(3), shapes=[engine.Placed(engine.Box((0.1, 0.1, 0.1)))], p_WB=(0.4 * k, 0, 0.1)
        )
        for k in range(4)
    ]  # fmt: skip
    options = engine.Options(broad_phase="sweep_and_prune", sleeping=True, sleep_time=0.1)
    return engine.World([GROUND, *boxes, _ball("ball", (0.02 * seed, 0, 0.5))], surfaces=ROUGH, options=options)


@pytest.mark.parametrize("build", [_free, _chain, _pile, _hulls, _tied, _crowd, _slanted, _sleepers])
def test_worlds_in_a_batch_end_with_the_bits_they_have_alone(build: Callable[[int], engine.World]) -> None:
    """States and everything else that decides the future, contacts included, in calls of one and of many steps."""
    worlds = [build(seed) for seed in range(6)]
    batch = engine.Batch(worlds)
    for count in (1, 1, 118):
        batch.step(count)
    for world in worlds:
        world.step(120)
    assert np.array_equal(batch.state(), [world.state() for world in worlds])
    for k, world in enumerate(worlds):
        assert batch.world(k).steps == 120
        assert np.array_equal(batch.world(k).contacts().force, world.contacts().force)


def test_a_batch_may_hold_worlds_of_different_kinds() -> None:
    """Two bodies each: flying, tied, and in contact."""
    flying = engine.World([engine.Body(name="a", v_WB=(1, 0, 0)), engine.Body(name="b", p_WB=(1, 0, 0))])
    tie = engine.Ball(name="j", parent="a", child="b", anchor_W=(0, 0, 0))
    tied = engine.World([engine.Body(name="a"), engine.Body(name="b", p_WB=(1, 0, 0), v_WB=(0, 1, 0), w_WB=(0, 0, 1))], [tie])
    resting = engine.World([GROUND, _body("b", engine.Sphere(0.1), np.random.default_rng(1), p_WB=(0, 0, 0.1))])
    worlds = [flying, resting, tied, flying]
    batch = engine.Batch(worlds)
    batch.step(50)
    for world in (flying, resting, tied):
        world.step(50)
    assert np.array_equal(batch.state(), [world.state() for world in worlds])


def test_the_worlds_given_are_left_alone_and_replicas_part_by_their_loads() -> None:
    """Newton: under f = k newton a mass of 1 kg reaches v = k t, whatever its neighbours do."""
    world = engine.World([engine.Body()], gravity=(0, 0, 0))
    batch = engine.Batch.replicate(world, 5)
    force = np.zeros((5, 1, 3))
    force[:, 0, 0] = np.arange(5)
    batch.set_load(force, np.zeros((5, 1, 3)))
    batch.step(240)
    assert batch.state()[:, 0, 7] == pytest.approx(np.arange(5), abs=1e-12)
    assert world.steps == 0
    assert not world.state()[:, 7:].any()


def test_a_saved_batch_repeats_its_future_bit_for_bit() -> None:
    batch = engine.Batch([_pile(seed) for seed in range(3)])
    batch.step(30)
    saved = batch.save()
    batch.step(60)
    once = batch.state()
    batch.restore(saved)
    batch.step(60)
    assert np.array_equal(batch.state(), once)


def test_a_world_that_diverges_is_named_with_its_step_and_the_others_go_on() -> None:
    """A load of 1e308 N makes the velocity infinite in the first steps."""
    batch = engine.Batch.replicate(engine.World([engine.Body()]), 4)
    force = np.zeros((4, 1, 3))
    force[2, 0, 0] = 1e308
    batch.set_load(force, np.zeros((4, 1, 3)))
    with pytest.raises(engine.Diverged, match="world 2: the state is not finite after step") as caught:
        batch.step(2000)
    assert caught.value.world == 2
    assert caught.value.step == batch.world(2).steps < 2000
    assert [batch.world(k).steps for k in (0, 1, 3)] == [2000] * 3


def test_batches_refuse_what_they_cannot_advance() -> None:
    one, two = engine.World([engine.Body()]), engine.World([engine.Body(name="a"), engine.Body(name="b")])
    with pytest.raises(ValueError, match="no worlds"):
        engine.Batch([])
    with pytest.raises(ValueError, match="world 1 has 2 bodies, expected 1"):
        engine.Batch([one, two])
    with pytest.raises(ValueError, match="world 1 has 3 threads"):
        engine.Batch([one, engine.World([engine.Body()], options=engine.Options(threads=3))])
    with pytest.raises(ValueError, match="threads 0"):
        engine.Batch([one], threads=0)
    with pytest.raises(ValueError, match="step count -1"):
        engine.Batch([one]).step(-1)
    with pytest.raises(ValueError, match="f_B_W has shape"):
        engine.Batch([one]).set_load(np.zeros((1, 3)), np.zeros((1, 1, 3)))
    touching = [GROUND, _body("b", engine.Sphere(0.1), np.random.default_rng(1))]
    with pytest.raises(ValueError, match="world 0 has 2 threads, expected 1"):
        engine.Batch([engine.World(touching, options=engine.Options(threads=2))])
    for options, what in ((engine.Options(solver="exact"), "exact"), (engine.Options(continuous="swept"), "swept")):
        with pytest.raises(engine.NotSupported, match=f"batch.*{what}"):
            engine.Batch([engine.World(touching, options=options)])


THREADS = f"""
import hashlib, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from plumbline import engine
from test_engine_batch import _free, _hulls, _pile
for build in (_free, _pile, _hulls):
    for threads in (1, 2, 4):
        batch = engine.Batch([build(seed) for seed in range(7)], threads)
        batch.step(60)
        print(hashlib.sha256(batch.state().tobytes()).hexdigest())
"""


@pytest.mark.compiler
def test_no_number_of_threads_changes_a_bit(fork: Fork) -> None:
    """Four threads exist in a process that is told so, however many cores there are; seven worlds do not divide evenly."""
    said = fork(THREADS).split()
    assert len(said) == 9
    assert [len(set(said[k : k + 3])) for k in (0, 3, 6)] == [1, 1, 1]


MADE = """
from plumbline import engine
def made(): return engine.World([engine.Body(p_WB=(0, 0, 1))], options=engine.Options(integrator="explicit_euler"))
"""


@pytest.mark.compiler
@pytest.mark.skipif(linker() is None, reason="Numba alone compiles what it calls by address within the caller")
def test_a_world_alone_finds_the_step_that_a_batch_has_compiled(tmp_path: Path, fork: Fork) -> None:
    """Each in a process of its own; asked for under another signature, the same step would be compiled and kept twice."""
    engine.Batch([engine.World([engine.Body()], options=engine.Options(integrator="explicit_euler"))]).step()
    for module in (many_worlds, runge_kutta):
        kept = cache_directory(Path(module.__file__))
        shutil.copytree(kept, tmp_path / kept.name)
    for what in ("engine.Batch([made(), made()])", "made()"):
        fork(MADE + f"{what}.step()", PLUMBLINE_KERNEL_CACHE=str(tmp_path))
        assert len([*tmp_path.rglob("runge_kutta.step_explicit_euler-*.nbc")]) == 1
