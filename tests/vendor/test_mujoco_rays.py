"""What MuJoCo's rays search, asked through mujoco alone: bounding volumes, which it builds where shapes may collide."""

import math
import time

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

SOLIDS, RAYS, REACH = 50, 8192, 30.0
SHAPES = [f'type="{kind}" size="{size}"' for kind, size in (("sphere", ".5"), ("box", ".4 .3 .6"), ("capsule", ".25 .5"))]


def yard(law: str) -> str:
    """A floor and fifty solids on a sunflower spiral, each a body of its own that stands still, and one body that flies."""
    world = f'<body><geom type="plane" size="0 0 1" {law}/></body>'
    for k in range(SOLIDS):
        way, turn = 1.5 * math.sqrt(k + 4), k * math.pi * (3 - math.sqrt(5))
        pose = f'pos="{way * math.cos(turn)!r} {way * math.sin(turn)!r} 1" euler="{20 * k} {35 * k} 0"'
        world += f"<body {pose}><geom {SHAPES[k % 3]} {law}/></body>"
    return world + '<body pos="0 0 9"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia=".1 .1 .1"/></body>'


def cast(law: str, more: str = "") -> tuple[int, tuple[NDArray[np.float64], ...], float]:
    """The bounding volumes of the yard, geoms, distances and normals of rays into it, and the least CPU time of three casts."""
    model, data = load(yard(law), 1 / 240, more=more)
    mujoco.mj_forward(model, data)
    ways = np.random.default_rng(0).normal(size=(RAYS, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    geom, distance, normal = np.full(RAYS, -1, np.int32), np.zeros(RAYS), np.zeros(3 * RAYS)
    taken = []
    for _ in range(3):
        begun = time.process_time()
        mujoco.mj_multiRay(
            model, data, np.array((0.0, 0.0, 1.2)), ways.reshape(-1), None, True, -1, geom, distance, normal, RAYS, REACH
        )
        taken.append(time.process_time() - begun)
    return int(model.nbvh), (geom.astype(np.float64), distance, normal), min(taken)


def test_shapes_that_may_collide_and_stand_in_one_body_have_a_tree_of_volumes_and_the_same_answers() -> None:
    fused = '<compiler fusestatic="true"/>'
    plain, answers, longest = cast('contype="0" conaffinity="0"')
    apart, same, _ = cast("")
    together, again, shortest = cast("", fused)
    without, _, _ = cast('contype="0" conaffinity="0"', fused)
    print(f"a ray {1e9 * longest / RAYS:.0f} ns without volumes, {1e9 * shortest / RAYS:.0f} ns with a tree of them")
    # A leaf for each shape; a binary tree of n leaves has 2 n - 1 nodes.
    assert (plain, without) == (0, 0)
    assert apart == SOLIDS + 1
    assert together == 2 * (SOLIDS + 1) - 1
    for one, two, three in zip(answers, same, again, strict=True):
        np.testing.assert_array_equal(one, two)
        np.testing.assert_array_equal(one, three)
