"""Bullet's many steps in one native call are those of as many calls: states bit for bit, and all that is read in between."""

import math

import numpy as np
import pytest

pytest.importorskip("pybullet")

from plumbline.adapters.bullet import ADAPTER
from plumbline.adapters.bullet.native_steps import length_of
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import Body, Box, PlacedShape, Scene, Surface, TriangleMesh
from plumbline.harness.trajectory import State

CUBE = Box(half_extents=(0.1, 0.1, 0.1))


def pile() -> Scene:
    """Three cubes above each other, askew, over the ground."""
    cubes = tuple(
        Body(
            name=f"cube_{k}", material="cube", p_WB=(0.02 * k, 0.0, 0.15 + 0.25 * k), q_WB=(math.cos(0.1), math.sin(0.1), 0.0, 0.0),
            inertia=((1 / 150, 0, 0), (0, 1 / 150, 0), (0, 0, 1 / 150)), collision=(PlacedShape(shape=CUBE),),
        )
        for k in range(3)
    )  # fmt: skip
    laws = (Surface.rough(0.5, ("cube", "ground")), Surface.rough(0.5, ("cube", "cube")))
    return Scene(bodies=(Body.ground(), *cubes), surfaces=laws)


def places(settings: Settings, counts: list[int], listening: bool = False) -> np.ndarray:  # type: ignore[type-arg]
    """Poses and velocities after steps in such portions."""
    scene = pile()
    simulation, out = ADAPTER.build(scene, settings), State.empty(len(scene.bodies))
    try:
        if listening:
            simulation.contacts()
        for count in counts:
            simulation.step(count)
        simulation.state(out)
    finally:
        simulation.close()
    return np.hstack((out.p_WB, out.q_WB, out.v_WB, out.w_WB))


@pytest.mark.parametrize("track", ["default", "tuned"])
@pytest.mark.parametrize("dt", [1 / 60, 1 / 240, 1e-3, 0.0031])
def test_portions_of_any_size_come_to_the_same_bits(track: str, dt: float) -> None:
    from dataclasses import replace

    settings = replace(ADAPTER.tracks[track], dt=dt)
    singly = places(settings, [1] * 111)
    assert np.array_equal(places(settings, [111]), singly)
    assert np.array_equal(places(settings, [3, 1, 7, 100]), singly)
    assert np.array_equal(places(settings, [111], listening=True), singly)


def test_a_length_falls_into_so_many_steps_to_the_last_bit() -> None:
    steps = [1 / rate for rate in (15, 30, 60, 240, 480, 960, 1000, 1920, 7680)] + [0.0031]
    for h in steps:
        for count in (2, 3, 49, 98, 103, 1000):
            length = length_of(count, h)
            if length is not None:
                assert length / count == h
                assert math.floor(length / (length / count)) == count


def wall(motion: str) -> Scene:
    """Two plates of triangles, of which one may move."""
    mesh = TriangleMesh(vertices=((-1, -1, 0), (1, -1, 0), (0, 1, 0)), faces=((0, 1, 2),))
    plates = (
        Body(name="still", motion="static", material="plate", collision=(PlacedShape(shape=mesh),)),
        Body(name="other", motion=motion, material="plate", p_WB=(0.0, 0.0, 1.0), collision=(PlacedShape(shape=mesh),)),
    )
    return Scene(bodies=plates, surfaces=(Surface.rough(0.5, ("plate", "plate")),))


def test_two_meshes_that_may_meet_are_refused_and_two_that_stand_still_are_not() -> None:
    settings = Settings(dt=1 / 240)
    with pytest.raises(Unsupported, match="two meshes of triangles"):
        ADAPTER.build(wall("dynamic"), settings)
    ADAPTER.build(wall("static"), settings).close()
