"""Nuts and bolts, bodies of one mesh each, are dropped into a bowl, come to rest and stay so.

What lies within what is measured apart from the engine's contacts: by points all over each mesh that the triangles of another
surround.
"""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from plumbline import engine
from tests.solid_meshes import bolt, bowl, deepest, mass_properties, mesh_body, nut, sag, scattered, volume

pytestmark = pytest.mark.usefixtures("solids_found_once")

Array = NDArray[np.float64]
G, STEEL = 9.81, 7850.0
ROUGH = {("steel", "steel"): engine.Surface(static_friction=0.5, kinetic_friction=0.5)}
RADIUS, HIGHEST, APART = 0.08, -0.05, 0.022
"""The bowl's inner radius, and above the middle of its rim's ball the lowest of the bodies and their distance [m]."""
STEPS = 240
BOWL = bowl(RADIUS, 0.005, 1.2)
KINDS = (bolt(), nut())


def _world(count: int, seed: int) -> tuple[engine.World, list[engine.TriangleMesh], list[float]]:
    """Bolts and nuts in turn, in a column over the bowl, each turned anyhow; the mesh and the mass of each body."""
    rng = np.random.default_rng(seed)
    bodies = [engine.Body(name="bowl", motion="static", material="steel", shapes=[engine.Placed(BOWL)])]
    meshes, masses = [BOWL], [math.inf]
    for k in range(count):
        mesh, turn = KINDS[k % 2], rng.normal(size=4)
        meshes.append(mesh)
        masses.append(STEEL * volume(mesh))
        place = (*rng.uniform(-0.02, 0.02, 2), HIGHEST + APART * k)
        turn = turn / np.linalg.norm(turn)
        bodies.append(mesh_body(str(k), mesh, mass=masses[-1], material="steel", p_WB=place, q_WB=turn))
    return engine.World(bodies, surfaces=ROUGH), meshes, masses


def _depth(world: engine.World, meshes: list[engine.TriangleMesh]) -> float:
    """How deep [m] a point of any body lies in another."""
    places = []
    for state, mesh in zip(world.state(), meshes, strict=True):
        turn = Rotation.from_quat(state[3:7], scalar_first=True).as_matrix()
        middle = np.zeros(3) if mesh is BOWL else mass_properties(mesh, 1.0)[0]
        places.append((turn, state[:3] - turn @ middle))
    most = 0.0
    for i, (turn, place) in enumerate(places):
        points = scattered(meshes[i], 4) @ turn.T + place
        for j, (other, there) in enumerate(places):
            if i != j:
                most = max(most, deepest((points - there) @ other, meshes[j]))
    return most


@pytest.mark.parametrize(
    ("count", "seed", "still", "seconds"),
    [
        (4, 3, 3, 1),
        *(
            pytest.param(n, s, 3, 8, marks=pytest.mark.slow)
            for n, s in ((4, 3), (8, 1), (8, 2), (8, 3), (20, 1), (20, 2), (20, 4), (20, 5))
        ),
        pytest.param(20, 3, 6, 8, marks=pytest.mark.slow),
    ],
)
def test_nuts_and_bolts_come_to_rest_in_a_bowl_and_stay(count: int, seed: int, still: int, seconds: int) -> None:
    """From so many seconds on nothing moves: by less than a nanometre in 8 s, and no faster than one a second.

    Roundings decide how twenty come to lie: one heap of five rocks on, by 1e-7 m/s at 3 s, 5e-10 at 6 s and 3e-11 at 8 s;
    the others are slower than 1e-11 at 4 s. In the second before, what comes to rest moves by no more than contacts give way.
    A contact is a spring of a quarter of the sub-step's rate for its own body, so one that bore all there is would give way by
    the sag of one body times their masses over the least. Falling, nothing goes deeper than the blow of the whole height into
    such a spring without its damping. What lies in another lies no deeper than the deepest contact says.
    """
    world, meshes, masses = _world(count, seed)
    bound = sag(1 / STEPS) * sum(masses[1:]) / min(masses)
    blow = math.sqrt(2 * G * (RADIUS + HIGHEST + APART * count)) / (2 * math.pi * STEPS)
    for blocks in (12 * (still - 1), 12):
        start = world.state().copy()
        for _ in range(blocks):
            world.step(20)
            assert world.contacts().gap.min(initial=0.0) > -blow - bound
    assert np.abs(world.state()[:, :3] - start[:, :3]).max() < bound
    start = world.state().copy()
    for _ in range(4):
        world.step(seconds * STEPS // 4)
        assert np.abs(world.state()[1:, 7:10]).max() < 1e-9
        assert np.abs(world.state()[:, :3] - start[:, :3]).max() < 1e-9
        assert world.contacts().gap.min() > -bound
    assert (np.linalg.norm(world.state()[1:, :3], axis=1) < RADIUS).all()
    contacts = world.contacts()
    up = contacts.force[contacts.bodies[:, 0] == 0, 2].sum() - contacts.force[contacts.bodies[:, 1] == 0, 2].sum()
    assert up == pytest.approx(G * sum(masses[1:]), rel=1e-6)
    deep = _depth(world, meshes)
    assert 0.0 < deep < -contacts.gap.min() + 1e-9
