"""Bodies of closed meshes that forces move: they rest, stack, hang in each other and fall as solids of their form do."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline import engine
from plumbline.engine.narrow.triangle_triangle import APART
from tests.engine_entries import measure_triangles
from tests.solid_meshes import box, mesh_body, nut, ring, sag, together

pytestmark = pytest.mark.usefixtures("solids_found_once")

G = 9.81
SINK = sag(1 / 240)
"""4.3 um; several points that share a weight give way by less, each being tuned for the whole body."""
QUIET = G / 960 / 50
"""Speeds [m/s, rad/s] of what rests on more points than it needs: a fiftieth of what gravity gives in a sub-step. The sharing
of loads moves impulses from point to point in each, and three sweeps bring them back; a box on a mesh is left as much.
"""
ROUGH = {("default", "default"): engine.Surface(static_friction=0.5, kinetic_friction=0.5)}
GROUNDS: dict[str, engine.Shape] = {
    "plane": engine.Plane(),
    "box": engine.Box((1.0, 1.0, 0.5)),
    "mesh": box((1.0, 1.0, 0.5)),
    "hull": engine.ConvexHull(box((1.0, 1.0, 0.5)).vertices),
}
UP = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
ELL = together(box((0.1, 0.05, 0.05)), box((0.05, 0.05, 0.05), (-0.05, 0.0, 0.1)))
"""A foot of 20 by 10 by 10 cm with a cube on one end: two boxes in touch."""


def _ground(kind: str) -> engine.Body:
    middle = (0.013, 0.017, 0.0 if kind == "plane" else -0.5)
    return engine.Body(name="ground", motion="static", shapes=[engine.Placed(GROUNDS[kind])], p_WB=middle)


def _carried(world: engine.World) -> float:
    """What the first body carries [N], upwards."""
    contacts = world.contacts()
    return float(contacts.force[contacts.bodies[:, 0] == 0, 2].sum() - contacts.force[contacts.bodies[:, 1] == 0, 2].sum())


@pytest.mark.parametrize("kind", GROUNDS)
def test_a_cube_of_triangles_falls_on_a_ground_of_any_kind_and_rests(kind: str) -> None:
    """From 5 cm up, a corner first: it comes to lie on a face, quietly, within SINK of its half width, and is carried."""
    turn = np.array([1.0, 0.2, 0.3, 0.1])
    cube = mesh_body("cube", box((0.1, 0.1, 0.1)), p_WB=(0, 0, 0.25), q_WB=turn / np.linalg.norm(turn))
    world = engine.World([_ground(kind), cube], surfaces=ROUGH)
    world.step(480)
    state = world.state()[1]
    assert 0.1 - SINK < state[2] < 0.1
    assert np.abs(state[7:]).max() < QUIET
    assert _carried(world) == pytest.approx(G, rel=1e-3)


@pytest.mark.parametrize("kind", ["box", pytest.param("hull", marks=pytest.mark.slow)])
def test_a_cube_of_triangles_falls_on_a_slab_off_the_middle_and_rests(kind: str) -> None:
    """Three cubes of 10 cm fall by 4 to 8 cm, each turned anyhow, 16 cm beside the middle of a slab of 80 cm."""
    rng = np.random.default_rng(1)
    for _ in range(3):
        turn = rng.normal(size=4)
        cube = mesh_body("cube", box((0.05, 0.05, 0.05)), p_WB=(0.16, 0, 0.13), q_WB=turn / np.linalg.norm(turn))
        half = (0.4, 0.4, 0.05)
        corners = [(x * half[0], y * half[1], z * half[2]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        slab = engine.Placed(engine.Box(half) if kind == "box" else engine.ConvexHull(corners), (0, 0, -0.05))
        world = engine.World([engine.Body(name="ground", motion="static", shapes=[slab]), cube], surfaces=ROUGH)
        world.step(480)
        assert 0.05 - SINK < world.state()[1, 2] < 0.05


@pytest.mark.parametrize("apart", [{"threads": 2}, {"sleeping": True, "sleep_time": 1e6}], ids=["threads", "sleep"])
def test_a_cube_of_triangles_that_is_solved_as_an_island_ends_with_the_bits_of_one_that_is_not(apart: dict[str, Any]) -> None:
    """Its dozen contacts share its load either way."""
    cube = mesh_body("cube", box((0.1, 0.1, 0.1)), p_WB=(0, 0, 0.1005))
    worlds = [engine.World([_ground("mesh"), cube], surfaces=ROUGH, options=engine.Options(**own)) for own in ({}, apart)]
    for world in worlds:
        world.step(240)
    assert worlds[0].state().tobytes() == worlds[1].state().tobytes()


def test_cubes_of_triangles_stack_edge_on_edge_and_askew() -> None:
    """Set down in touch, the second in line with the first, so that sides and edges coincide, the third turned: they stay."""
    turn = (math.cos(0.4), 0.0, 0.0, math.sin(0.4))
    cubes = [
        mesh_body(f"c{k}", box((0.1, 0.1, 0.1)), p_WB=(0, 0, 0.1 + 0.2 * k), q_WB=turn if k == 2 else (1, 0, 0, 0))
        for k in range(3)
    ]
    world = engine.World([_ground("mesh"), *cubes], surfaces=ROUGH)
    world.step(480)
    state = world.state()[1:]
    sunk = [0.1 + 0.2 * k for k in range(3)] - state[:, 2]
    assert (np.diff(sunk, prepend=0.0) > 0).all()
    assert sunk[2] < 6 * SINK
    assert np.abs(state[:, :2]).max() < 5e-5
    assert np.abs(state[:, 7:]).max() < QUIET
    assert _carried(world) == pytest.approx(3 * G, rel=1e-3)


@pytest.mark.parametrize("solver", ["tgs_soft", "sequential_impulses"])
def test_a_foot_with_a_cube_on_one_end_stands_where_its_mesh_says(solver: str) -> None:
    """It stands on its foot; in the notch over the other end stands the cube of a second one, upside down."""
    rules = {"substeps": 1, "iterations": 20} if solver == "sequential_impulses" else {}
    middle = -np.asarray(mesh_body("low", ELL).shapes[0].p_BS)
    low = mesh_body("low", ELL, p_WB=middle + np.array([0, 0, 0.05]))
    high = mesh_body("high", ELL, p_WB=middle * (-1, 1, -1) + np.array([0, 0, 0.25]), q_WB=(0, 0, 1, 0))
    world = engine.World([_ground("mesh"), low, high], surfaces=ROUGH, options=engine.Options(solver=solver, **rules))  # type: ignore[arg-type]
    world.step(480)
    state = world.state()[1:]
    assert np.abs(state[:, :3] - [low.p_WB, high.p_WB]).max() < 1e-4
    assert np.abs(state[:, 7:]).max() < QUIET
    assert _carried(world) == pytest.approx(2 * G, rel=1e-3)


@pytest.mark.parametrize(
    "mesh",
    [
        pytest.param(box((0.1, 0.1, 0.1)), id="cube"),
        pytest.param(ELL, id="foot"),
        pytest.param(nut(0.2, 0.12, 0.2, 24), id="nut", marks=pytest.mark.slow),
    ],
)
def test_a_mesh_slides_over_the_seams_of_a_mesh_as_over_a_plane(mesh: engine.TriangleMesh) -> None:
    """Without friction nothing may slow it. It may lean by SINK over its width of 20 cm, which pushes it along by g times that;
    a side that met a seam would take centimetres a second.
    """
    line = np.linspace(-1.3, 1.3, 14)
    cells = [14 * i + j for i in range(13) for j in range(13)]
    faces = [face for a in cells for face in ((a, a + 14, a + 15), (a, a + 15, a + 1))]
    grid = engine.Placed(engine.TriangleMesh([(x, y, 0.0) for x in line for y in line], faces))
    body = mesh_body("body", mesh, v_WB=(1.5, 0.1, 0))
    height = float(body.shapes[0].p_BS[2]) + float(np.asarray(mesh.vertices)[:, 2].min())
    body = mesh_body("body", mesh, p_WB=(-0.9, 0.013, -height), v_WB=(1.5, 0.1, 0))
    world = engine.World([engine.Body(name="floor", motion="static", shapes=[grid]), body])
    world.step(240)
    state = world.state()[1]
    assert state[:3] == pytest.approx([0.6, 0.113, -height], abs=G * SINK / 0.2 / 2)
    assert state[7:9] == pytest.approx([1.5, 0.1], abs=G * SINK / 0.2)
    assert np.abs(state[9:]).max() < 1e-4


def test_a_ring_hangs_in_a_ring_and_does_not_leave_it() -> None:
    """Two links of a chain, 3 cm to the middle of a tube of 8 mm: let go 1 mm above where it hangs, the lower one hangs 44 mm
    below, to the sagitta of the sides of both tubes, r (1 - cos(pi / 10)) + R (1 - cos(pi / 20)) each.

    It sinks in by less than an undamped contact spring would give under the blow of that fall, sqrt(2 g 1 mm) / omega.
    """
    link = ring(0.03, 0.008)
    fixed = engine.Body(name="fixed", motion="static", shapes=[engine.Placed(link)], q_WB=UP, p_WB=(0, 0, 1))
    low = mesh_body("low", link, mass=0.05, p_WB=(0, 0, 1 - 0.043), q_WB=(math.sqrt(0.5), 0, math.sqrt(0.5), 0))
    world = engine.World([fixed, low], surfaces=ROUGH)
    lowest, deepest = math.inf, 0.0
    for _ in range(24):
        world.step(20)
        lowest, deepest = min(lowest, float(world.state()[1, 2])), min(deepest, float(world.contacts().gap.min(initial=0.0)))
    flat = 0.008 * (1 - math.cos(math.pi / 10)) + 0.03 * (1 - math.cos(math.pi / 20))
    assert lowest > 1 - 0.044 - 1e-4
    assert world.state()[1, 2] < 1 - 0.044 + 2 * flat
    assert -deepest < math.sqrt(2 * G * 1e-3) / (2 * math.pi * 240)
    assert _carried(world) == pytest.approx(0.05 * G, rel=0.02)


def _crossings(one: engine.TriangleMesh, two: engine.TriangleMesh, pose: NDArray[np.float64]) -> int:
    """How many triangles of two meshes cross, the second at p_WB, q_WB (7,)."""
    from scipy.spatial.transform import Rotation

    placed = Rotation.from_quat(pose[3:], scalar_first=True).apply(np.asarray(two.vertices)) + pose[:3]
    a, b = np.asarray(one.vertices)[np.asarray(one.faces)], placed[np.asarray(two.faces)]
    pairs = np.repeat(a, len(b), axis=0).reshape(-1, 9), np.tile(b, (len(a), 1, 1)).reshape(-1, 9)
    kind, ends = np.zeros((len(pairs[0]), 3), np.int64), np.zeros((len(pairs[0]), 6))
    measure_triangles(*pairs, kind, ends)
    return int((kind[:, 0] != APART).sum())


@pytest.mark.parametrize("poses", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_contacts_of_penetration_are_there_where_triangles_cross_and_nowhere_else(poses: int) -> None:
    """Two rings, in a third of the poses apart: a gap below zero is told if and only if some triangles cross."""
    one = ring(0.03, 0.008, 12, 6)
    rng = np.random.default_rng(4)
    fixed = engine.Body(name="fixed", motion="static", shapes=[engine.Placed(one)])
    told = []
    for _ in range(poses):
        q = rng.normal(size=4)
        way = rng.normal(size=3)
        pose = np.concatenate([way * rng.uniform(0.03, 0.08) / np.linalg.norm(way), q / np.linalg.norm(q)])
        body = mesh_body("ring", one, p_WB=pose[:3], q_WB=pose[3:])
        world = engine.World([fixed, body], gravity=(0, 0, 0), options=engine.Options(dt=1e-9, margin=0.0))
        world.step(1)
        told.append(((world.contacts().gap < -1e-6).any(), _crossings(one, one, pose) > 0))
    assert 0.2 < np.mean([crosses for _, crosses in told]) < 0.9
    assert [deep for deep, _ in told] == [crosses for _, crosses in told]


def test_an_open_mesh_that_forces_move_and_its_swept_collision_are_refused() -> None:
    whole = box((0.1, 0.1, 0.1))
    torn = engine.TriangleMesh(whole.vertices, whole.faces[1:])
    with pytest.raises(engine.NotSupported, match=r"triangle mesh of body 'torn', which forces move: .* has one face"):
        engine.World([engine.Body(name="torn", shapes=[engine.Placed(torn)])])
    engine.World([engine.Body(name="torn", motion="static", shapes=[engine.Placed(torn)])])
    with pytest.raises(engine.NotSupported, match="swept collision of triangle meshes that forces move"):
        engine.World([_ground("mesh"), mesh_body("cube", whole)], options=engine.Options(continuous="swept"))


@pytest.mark.parametrize(
    "options",
    [
        {"broad_phase": "octree"},
        {"bounding_volume": "sphere"},
        *(pytest.param({"broad_phase": name}, marks=pytest.mark.slow) for name in ("sweep_and_prune", "bvh", "brute_force")),
        pytest.param({"bounding_volume": "obb"}, marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_however_pairs_are_found_meshes_end_in_the_same_bits(options: dict[str, str]) -> None:
    def end(**chosen: str) -> NDArray[np.float64]:
        rings = [
            mesh_body(f"r{k}", ring(0.05, 0.015, 8, 5), p_WB=(0.01 * k, 0, 0.03 + 0.04 * k), w_WB=(k, 1, 2)) for k in range(3)
        ]
        world = engine.World([_ground("mesh"), *rings], surfaces=ROUGH, options=engine.Options(**chosen))  # type: ignore[arg-type]
        world.step(60)
        assert len(world.contacts().gap) > 30
        return world.state().copy()

    assert np.array_equal(end(**options), end(broad_phase="uniform_grid"))


def test_many_worlds_of_moving_meshes_end_as_one_alone() -> None:
    bodies = [_ground("mesh"), mesh_body("cube", box((0.1, 0.1, 0.1)), p_WB=(0, 0, 0.13), w_WB=(1, 2, 0.5))]
    world = engine.World(bodies, surfaces=ROUGH)
    batch = engine.Batch.replicate(world, 2)
    world.step(60)
    batch.step(60)
    assert np.array_equal(batch.state()[0], world.state())
    assert np.array_equal(batch.state()[1], world.state())
