"""Bodies of hulls, cylinders and meshes in motion: they stack, rest, slide and roll as the closed forms say."""

import itertools
import math

import numpy as np
import pytest

from plumbline import engine
from tests.forks import Fork

G = 9.81
ROUGH = {("default", "default"): engine.Surface(static_friction=0.5, kinetic_friction=0.5)}
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
SLAB = engine.Body(name="slab", motion="static", shapes=[engine.Placed(engine.Box((2, 2, 0.5)))], p_WB=(0, 0, -0.5))
CORNERS = list(itertools.product((-0.1, 0.1), (-0.1, 0.1), (-0.1, 0.1)))
X_UP = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
H = 1 / 960
"""The sub-step [s] of four in a step of 1/240 s."""
SINK = G * (2 * H / math.pi) ** 2
"""How far [m] a body sinks into one contact spring of a quarter of the sub-step's rate: g / (2 pi / (4 h))^2 = 4.3 um."""


def _grid(size: float, cells: int) -> engine.TriangleMesh:
    """A flat floor of 2 cells^2 triangles."""
    n = cells + 1
    line = np.linspace(-size, size, n)
    vertices = [(x, y, 0.0) for x in line for y in line]
    faces = []
    for i, j in itertools.product(range(cells), repeat=2):
        a, b, c, d = n * i + j, n * (i + 1) + j, n * (i + 1) + j + 1, n * i + j + 1
        faces += [(a, b, c), (a, c, d)]
    return engine.TriangleMesh(vertices, faces)


FLOOR = engine.Body(name="floor", motion="static", shapes=[engine.Placed(_grid(1.3, 13))])


def _cubes(shape: engine.Shape, count: int) -> list[engine.Body]:
    return [
        engine.Body(name=f"c{k}", inertia=np.eye(3) / 150, shapes=[engine.Placed(shape)], p_WB=(0, 0, 0.1 + 0.2 * k))
        for k in range(count)
    ]


def _cylinder(radius: float, half: float, **state: object) -> engine.Body:
    across = radius**2 / 4 + half**2 / 3
    inertia = np.diag([across, across, radius**2 / 2])
    return engine.Body(name="cylinder", inertia=inertia, shapes=[engine.Placed(engine.Cylinder(radius, half))], **state)  # type: ignore[arg-type]


def test_cubes_of_hulls_stack_like_boxes() -> None:
    """Five cubes on a plane: each contact carries what lies above, so the springs give SINK times its number of cubes.

    Boxes and hulls have the same contacts but for rounding, so they sink alike to a hundredth of that.
    """
    sunk = []
    for shape in (engine.Box((0.1, 0.1, 0.1)), engine.ConvexHull(CORNERS)):
        world = engine.World([GROUND, *_cubes(shape, 5)], surfaces=ROUGH)
        world.step(480)
        assert len(world.contacts().gap) == 20
        assert np.abs(world.state()[1:, 7:]).max() < 1e-5
        sunk.append(world.state()[1:, 2] - [0.1 + 0.2 * k for k in range(5)])
        assert np.abs(world.state()[1:, :2]).max() < 1e-4
    assert sunk[1] == pytest.approx(sunk[0], abs=0.05 * abs(sunk[0][-1]))


@pytest.mark.parametrize("ground", [GROUND, SLAB, FLOOR], ids=["plane", "box", "mesh"])
@pytest.mark.parametrize(("turn", "height"), [((1, 0, 0, 0), 0.15), (X_UP, 0.1)], ids=["upright", "lying"])
def test_a_cylinder_rests_quietly(ground: engine.Body, turn: tuple[float, ...], height: float) -> None:
    """Its points share its weight, each with a spring for its own mass: less than twice the sinking of one; no creep, and the
    ground carries m g.
    """
    world = engine.World([ground, _cylinder(0.1, 0.15, p_WB=(0.013, 0.017, height), q_WB=turn)], surfaces=ROUGH)
    world.step(480)
    p = world.state()[1, :3].copy()
    assert height - 2 * SINK < p[2] < height
    assert np.abs(world.state()[1, 7:]).max() < 1e-5
    assert world.contacts().force[:, 2].sum() * (1 if world.contacts().bodies[0, 0] == 0 else -1) == pytest.approx(G, rel=1e-3)
    world.step(480)
    assert np.abs(world.state()[1, :3] - p).max() < 1e-6


@pytest.mark.parametrize("ground", [GROUND, SLAB, FLOOR], ids=["plane", "box", "mesh"])
def test_a_cylinder_rolls_down_two_thirds_as_fast_as_it_would_slide(ground: engine.Body) -> None:
    """Pulled by f at its axis, a solid cylinder rolls with a = 2/3 f / m; seams of a flat mesh do not disturb it."""
    turn = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
    world = engine.World([ground, _cylinder(0.1, 0.15, p_WB=(-0.9, 0.013, 0.1), q_WB=turn)], surfaces=ROUGH)
    world.set_load([[0, 0, 0], [1.5, 0, 0]], np.zeros((2, 3)))
    world.step(240)
    state = world.state()[1]
    assert state[7] == pytest.approx(1.0, rel=2e-3)
    assert state[11] == pytest.approx(10.0, rel=2e-3)
    assert np.abs(state[[1, 2]] - (0.013, 0.1)).max() < 1e-4
    assert np.abs(state[[8, 9, 10, 12]]).max() < 1e-3


@pytest.mark.parametrize("shape", [engine.Box((0.1, 0.1, 0.1)), engine.ConvexHull(CORNERS)], ids=["box", "hull"])
def test_a_cube_slides_over_the_seams_of_a_mesh_as_over_a_plane(shape: engine.Shape) -> None:
    """Without friction nothing may slow it: it keeps its velocity to a millionth and does not turn."""
    body = engine.Body(
        name="cube", inertia=np.eye(3) / 150, shapes=[engine.Placed(shape)], p_WB=(-0.9, 0.013, 0.1), v_WB=(1.5, 0.1, 0)
    )  # fmt: skip
    world = engine.World([FLOOR, body])
    world.step(240)
    state = world.state()[1]
    assert state[7:9] == pytest.approx([1.5, 0.1], abs=1.5e-6)
    assert np.abs(state[9:]).max() < 1e-4
    assert state[2] == pytest.approx(0.1, abs=2 * SINK)


def test_a_ball_rolls_over_the_seams_of_a_mesh() -> None:
    """Seams of a flat floor give no sideways push: the ball keeps its line and its height."""
    ball = engine.Body(
        name="ball", inertia=0.4 * 0.01 * np.eye(3), shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(-0.9, 0.017, 0.1),
        v_WB=(1.5, 0.1, 0), w_WB=(-1.0, 15, 0),
    )  # fmt: skip
    world = engine.World([FLOOR, ball], surfaces=ROUGH)
    world.step(240)
    assert world.state()[1, :3] == pytest.approx([0.6, 0.117, 0.1], abs=1e-4)


def test_scenes_of_closed_forms_never_load_the_convex_narrow_phase(fork: Fork) -> None:
    """Its module is imported by the first pair that needs it, and with it its compilation."""
    code = (
        "import sys, engine; p = engine.Placed;"
        "w = engine.World([engine.Body(name='g', motion='static', shapes=[p(engine.Plane())]),"
        "engine.Body(shapes=[p(engine.Box((.1, .1, .1)))], p_WB=(0, 0, .1)),"
        "engine.Body(name='b', shapes=[p(engine.Cylinder(.1, .1))], p_WB=(9, 0, .1))]); w.step(3);"
        "assert len(w.contacts().gap) == 8; assert 'plumbline.engine.contact.collide_convex' not in sys.modules;"
        "assert 'plumbline.engine.narrow.gjk' not in sys.modules"
    )
    fork(code)
