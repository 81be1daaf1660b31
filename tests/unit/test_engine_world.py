"""The world as a whole: stages, broad phase, rays, saving, determinism, bad input, and compilation."""

import math
import os
import re
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.compile.jit import linker

DEFAULT = ("default", "default")
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
ROUGH = {DEFAULT: engine.Surface(static_friction=0.5, kinetic_friction=0.5, restitution=0.3)}


def _heap(**options: object) -> engine.World:
    """A dozen mixed bodies falling onto each other."""
    rng = np.random.default_rng(7)
    shapes: list[engine.Shape] = [engine.Sphere(0.1), engine.Box((0.1, 0.08, 0.12)), engine.Capsule(0.06, 0.1)]
    bodies = [
        engine.Body(
            name=f"b{k}",
            inertia=0.01 * np.eye(3),
            shapes=[engine.Placed(shapes[k % 3])],
            p_WB=(*rng.uniform(-0.15, 0.15, 2), 0.2 + 0.2 * k),
            q_WB=rng.normal(size=4),
        )
        for k in range(12)
    ]
    return engine.World([GROUND, *bodies], surfaces=ROUGH, options=engine.Options(**options))  # type: ignore[arg-type]


def test_stages_follow_from_what_the_world_contains() -> None:
    ball = engine.Body(name="ball", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 1))
    tied = engine.Ball(name="j", parent=engine.WORLD, child="ball", anchor_W=(0, 0, 2))
    assert engine.World([ball]).stages == ("integrator",)
    assert engine.World([ball], [tied]).stages == ("integrator", "joints")
    assert "contact solver" in engine.World([GROUND, ball]).stages
    assert engine.World([GROUND, ball], options=engine.Options(contacts=False)).stages == ("integrator",)


def test_sweep_and_prune_finds_what_brute_force_finds() -> None:
    """The oracle tests all pairs: after the same fall both have the same pairs in contact, whatever order solved them."""
    swept, brute = _heap(broad_phase="sweep_and_prune"), _heap(broad_phase="brute_force")
    for _ in range(60):
        start = swept.state().copy()
        brute.state()[:] = start
        swept.step()
        brute.step()
        pairs = [{tuple(sorted(pair)) for pair in world.contacts().bodies.tolist()} for world in (swept, brute)]
        assert pairs[0] == pairs[1]


def test_the_same_input_gives_the_same_bits() -> None:
    one, two = _heap(), _heap()
    one.step(120)
    for _ in range(120):
        two.step()
    assert one.state().tobytes() == two.state().tobytes()


def test_a_restored_world_repeats_its_future_bit_for_bit() -> None:
    """The warm-start impulses belong to the state: without them the first step after restoring would differ."""
    world = _heap()
    world.step(150)
    saved = world.save()
    world.step(60)
    first = world.state().tobytes()
    world.restore(saved)
    world.step(60)
    assert world.state().tobytes() == first


def test_more_pairs_than_expected_make_the_arena_grow() -> None:
    """Forty balls in one place have 780 pairs, more than eight a body."""
    balls = [engine.Body(name=f"b{k}", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(1e-3 * k, 0, 0.1)) for k in range(40)]
    world = engine.World(balls, surfaces=ROUGH)
    world.step()
    assert len(world.contacts().gap) == 780


def test_bodies_whose_materials_are_apart_pass_through_each_other() -> None:
    ghost = engine.Body(name="ghost", material="air", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 0.2))
    world = engine.World([GROUND, ghost], apart=[("air", "default")], options=engine.Options(integrator="rk4"))
    world.step(240)
    assert world.state()[1, 2] == pytest.approx(0.2 - 9.81 / 2, abs=1e-11)


def test_a_state_that_stops_being_finite_is_reported_with_its_step() -> None:
    world = engine.World([engine.Body(name="a")])
    world.step(3)
    world.state()[0, 7] = math.inf
    with pytest.raises(engine.Diverged) as caught:
        world.step(10)
    assert caught.value.step == 4


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"mass": 0.0}, "body 'bob': mass 0.0"),
        ({"inertia": np.diag([1.0, 1.0, 5.0])}, "body 'bob': inertia (1, 1, 5) kg m2 breaks the triangle inequality"),
        ({"inertia": np.diag([1.0, -1.0, 1.0])}, "not positive definite"),
        ({"inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "not symmetric"),
        ({"q_WB": (0, 0, 0, 0)}, "body 'bob': q_WB"),
        ({"p_WB": (0, math.nan, 0)}, "body 'bob': p_WB"),
        ({"linear_damping": -1.0}, "body 'bob': linear_damping -1.0"),
    ],
)
def test_bad_bodies_are_refused_by_name(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        engine.Body(name="bob", **arguments)  # type: ignore[arg-type]


def test_other_bad_input_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="options: dt 0"):
        engine.Options(dt=0)
    with pytest.raises(ValueError, match="joint 'j': axis_W"):
        engine.Revolute(name="j", parent="world", child="b", anchor_W=(0, 0, 0), axis_W=(0, 0, 0))
    with pytest.raises(ValueError, match="parent 'nobody' is no body"):
        engine.World([engine.Body(name="b")], [engine.Ball(name="j", parent="nobody", child="b", anchor_W=(0, 0, 0))])
    flat = engine.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    with pytest.raises(ValueError, match="convex hull: the vertices span no volume"):
        engine.World([engine.Body(name="b", shapes=[engine.Placed(flat)])])


def _unit(v: np.ndarray) -> np.ndarray:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _gap(shape: engine.Shape, x: np.ndarray) -> np.ndarray:
    """Signed distance of points (n, 3) from a shape, negative inside."""
    if isinstance(shape, engine.Sphere):
        return np.asarray(np.linalg.norm(x, axis=1) - shape.radius)
    if isinstance(shape, engine.Capsule):
        z = x[:, 2] - np.clip(x[:, 2], -shape.half_length, shape.half_length)
        return np.asarray(np.hypot(np.hypot(x[:, 0], x[:, 1]), z) - shape.radius)
    if isinstance(shape, engine.Box):
        d = np.abs(x) - np.asarray(shape.half_extents)
    else:
        assert isinstance(shape, engine.Cylinder)
        d = np.stack((np.hypot(x[:, 0], x[:, 1]) - shape.radius, np.abs(x[:, 2]) - shape.half_length), axis=1)
    return np.asarray(np.linalg.norm(np.maximum(d, 0), axis=1) + np.minimum(d.max(axis=1), 0))


SOLIDS = [engine.Sphere(0.5), engine.Box((0.3, 0.4, 0.5)), engine.Capsule(0.3, 0.4), engine.Cylinder(0.4, 0.3)]


@pytest.mark.parametrize("shape", SOLIDS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("inside", [False, True])
def test_rays_end_on_the_surface_and_nowhere_before(shape: engine.Shape, inside: bool) -> None:
    """The signed distance is zero at the hit, to round-off of lengths of 3 m: 1e-14, with a margin for grazing 1e-12; and it
    keeps its sign on the way. Misses stay outside all along.
    """
    rng = np.random.default_rng(3)
    q = _unit(rng.normal(size=4))
    p = np.array([1.0, -2.0, 0.5])
    world = engine.World([engine.Body(name="solid", motion="static", shapes=[engine.Placed(shape)], p_WB=p, q_WB=q)])
    w, x, y, z = q
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    directions = _unit(rng.normal(size=(400, 3)))
    local = rng.uniform(-0.15, 0.15, (400, 3)) if inside else 2.0 * _unit(rng.normal(size=(400, 3)))
    if not inside:
        directions = _unit(rng.uniform(-0.5, 0.5, (400, 3)) - local) @ turn.T
    origins = local @ turn.T + p
    hits = world.cast(origins, directions)
    hit = np.isfinite(hits.distance)
    assert hit.all() if inside else 100 < hit.sum() < 400
    assert (hits.body == np.where(hit, 0, -1)).all()
    ends = (origins + np.where(hit, hits.distance, 0.0)[:, None] * directions - p) @ turn
    assert np.abs(_gap(shape, ends[hit])).max() < 1e-12
    outward = hits.normal[hit] @ turn
    assert _gap(shape, ends[hit] + 1e-6 * outward) == pytest.approx(np.full(hit.sum(), 1e-6), abs=1e-9)
    for share in np.linspace(0.01, 0.99, 25):
        reach = share * np.where(hit, hits.distance, 5.0)
        sign = _gap(shape, (origins + reach[:, None] * directions - p) @ turn)
        assert (sign < 1e-12).all() if inside else (sign > -1e-12).all()


def test_rays_beyond_their_range_miss_and_planes_are_hit_from_above() -> None:
    world = engine.World([GROUND])
    hits = world.cast([[0, 0, 2.0], [0, 0, 2.0], [0, 0, 2.0]], [[0, 0, -1.0], [0, 0, 1.0], [0.6, 0, -0.8]], 2.2)
    assert hits.distance.tolist() == [2.0, math.inf, math.inf]
    assert hits.normal[0].tolist() == [0, 0, 1]
    assert hits.body.tolist() == [0, -1, -1]


def test_importing_the_engine_loads_no_compiler() -> None:
    code = "import sys, plumbline.engine; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.compiler
@pytest.mark.skipif(linker() is None, reason="Numba alone compiles a function anew for each constant")
def test_a_kernel_is_compiled_once_whatever_constants_it_is_called_with() -> None:
    """Compile time follows the number of compiled functions, and `load3` alone meets some forty different columns."""
    import numba

    from plumbline.engine.maths import rows

    def ends(a: rows.Floats) -> float:
        return float(rows.load3(a, 0, 0)[0] + rows.load3(a, 0, 3)[2])

    compiled: Any = numba.njit(ends)
    assert compiled(np.arange(6.0).reshape(1, 6)) == 5.0
    assert len(rows.load3.overloads) == 1  # type: ignore[attr-defined]


FALLS = """
import plumbline.engine as e, numpy as np
ground = e.Body(name="g", motion="static", shapes=[e.Placed(e.Plane())])
cube = [e.Placed(e.Box((0.5, 0.5, 0.5)))]
box = e.Body(name="b", inertia=np.eye(3) / 6, shapes=cube, p_WB=(0, 0, 0.6), q_WB=(1, 0.1, 0.2, 0))
for steps, solver, sweep in (
    (60, "tgs_soft", "off"), (12, "tgs_soft", "swept"),
    (12, "sequential_impulses", "off"), (12, "sequential_impulses", "swept"), (12, "exact", "off"),
):
    world = e.World([ground, box], options=e.Options(solver=solver, continuous=sweep))
    world.step(steps)
    print(*world.state()[1].tolist())
world = e.World([e.Body(name="top", inertia=np.diag([1.0, 2.0, 3.0]), w_WB=(1, 5, 2))], options=e.Options(integrator="rk4"))
world.step(12)
print(*world.state()[0].tolist())
"""
"""Where a box is after it fell on a plane, by each solver with and without a sweep, and a top that nothing holds."""


@pytest.mark.compiler
def test_the_kernels_run_without_compilation_and_give_the_same_fall(capsys: pytest.CaptureFixture[str]) -> None:
    """NUMBA_DISABLE_JIT=1 runs the same lines as plain Python: the numbers agree to fused multiply-adds."""
    plain = subprocess.run(
        [sys.executable, "-c", FALLS], check=True, capture_output=True, text=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}
    ).stdout.split()
    exec(FALLS, {})
    compiled = capsys.readouterr().out.split()
    assert np.array(compiled, float) == pytest.approx(np.array(plain, float), abs=1e-9)
