"""The order of elimination: what a mechanism costs and does does not hang on the order in which its joints are listed."""

import random
from collections.abc import Sequence

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.build.joint_order import elimination_order, factor_cost, neighbours

pytestmark = pytest.mark.usefixtures("both_coordinates")

Mechanism = tuple[list[engine.Body], list[engine.Joint]]


def _four_bars(count: int) -> Mechanism:
    """Parallelograms side by side, loop by loop: two feet, then two hinges of the coupler."""
    bodies, joints = [], []
    for k in range(count):
        for name, place in (("left", (0.25, k, -0.433)), ("coupler", (1.0, k, -0.866)), ("right", (1.25, k, -0.433))):
            bodies.append(engine.Body(name=f"{name}{k}", inertia=0.05 * np.eye(3), p_WB=place))
        for name, parent, child, x, z in (
            ("a", "world", f"left{k}", 0.0, 0.0),
            ("b", "world", f"right{k}", 1.0, 0.0),
            ("c", f"left{k}", f"coupler{k}", 0.5, -0.866),
            ("d", f"coupler{k}", f"right{k}", 1.5, -0.866),
        ):
            joints.append(engine.Revolute(name=f"{name}{k}", parent=parent, child=child, anchor_W=(x, k, z), axis_W=(0, 1, 0)))
    return bodies, joints


def _tree(above: list[int]) -> Mechanism:
    """Bodies that hang on each other by balls; body k hangs on body above[k], or on the world for -1."""
    bodies = [engine.Body(name=f"body{k}", p_WB=(0, 0, -k)) for k in range(len(above))]
    names = [body.name for body in bodies] + [engine.WORLD]
    joints = [engine.Ball(name=f"ball{k}", parent=names[a], child=f"body{k}", anchor_W=(0, 0, -k)) for k, a in enumerate(above)]
    return bodies, list(joints)


def _random_tree(count: int, seed: int) -> Mechanism:
    some = random.Random(seed)
    return _tree([-1] + [some.randrange(k) for k in range(1, count)])


def _by_kind(joints: list[engine.Joint]) -> list[engine.Joint]:
    """All feet first, then all other joints."""
    return sorted(joints, key=lambda joint: joint.parent != engine.WORLD)


@pytest.mark.parametrize("both_coordinates", ["maximal"], indirect=True)  # of which an order knows nothing
@pytest.mark.parametrize(
    "mechanism",
    [
        _four_bars(40),
        _tree(list(range(-1, 99))),
        _tree([(k - 1) // 2 for k in range(63)]),
        _random_tree(80, 1),
        pytest.param(_random_tree(80, 2), marks=pytest.mark.slow),
    ],
    ids=["four-bars", "chain", "binary tree", "random tree", "another random tree"],
)
def test_what_the_factor_costs_hardly_depends_on_the_order_of_the_list(mechanism: Mechanism) -> None:
    """Any order of the list is to cost at most 1.2 of the best; shuffled at random they differ by factors of 2 to 1500."""
    bodies, joints = mechanism
    lists = [joints, joints[::-1], _by_kind(joints)] + [random.Random(seed).sample(joints, len(joints)) for seed in range(6)]
    as_listed = [_cost(bodies, listed) for listed in lists]
    costs = [_cost(bodies, elimination_order(bodies, listed)) for listed in lists]
    assert max(costs) <= 1.2 * min(costs)
    assert min(costs) <= min(as_listed)
    assert max(as_listed) > 1.2 * min(costs)


def _cost(bodies: Sequence[engine.Body], joints: Sequence[engine.Joint]) -> int:
    """What the factor costs in the order of the joints."""
    return factor_cost(range(len(joints)), neighbours(bodies, joints), joints)


def test_four_bars_listed_feet_first_fill_as_little_as_loop_by_loop() -> None:
    """The envelope of the factor as the kernels wrote it: a loop has 20 rows, so no row reaches back further than that."""
    from plumbline.engine.memory import arena as at
    from plumbline.engine.memory.arena import float_table

    bodies, joints = _four_bars(12)
    fill = []
    for listed in (joints, _by_kind(joints)):
        world = engine.World(bodies, listed, options=engine.Options(integrator="rk4"))
        world.step()
        floats, ints = world.save()
        first = float_table(floats, ints, at.VECTOR)[at.ENVELOPE, : 20 * 12]
        fill.append(int((np.arange(20 * 12) - first).sum()))
    assert fill[0] == fill[1] < 20 * 20 * 12


@pytest.mark.parametrize("integrator", [pytest.param("rk4", marks=pytest.mark.slow), "semi_implicit_euler"])
def test_mechanisms_move_alike_and_drives_keep_their_names_in_any_order(integrator: str) -> None:
    """Another order rounds otherwise: 1e-16 a step in velocities of 5 m/s, over 240 steps, grown by no more than 1e3."""
    bodies, joints = _four_bars(3)
    joints[4] = engine.Revolute(
        name="a1",
        parent="world",
        child="left1",
        anchor_W=(0, 1, 0),
        axis_W=(0, 1, 0),
        drive=engine.Drive(stiffness=40, damping=4),
    )
    ends = []
    for listed in (joints, _by_kind(joints), joints[::-1]):
        world = engine.World(bodies, listed, options=engine.Options(integrator=integrator))
        world.command("a1", 0.3)
        world.step(240)
        ends.append(world.state().copy())
    assert ends[1] == pytest.approx(ends[0], abs=1e-10)
    assert ends[2] == pytest.approx(ends[0], abs=1e-10)
    assert np.abs(ends[0][3:6, :3] - ends[0][:3, :3] - (0, 1, 0)).max() > 0.01


def test_a_list_that_nothing_beats_stays_as_it_is() -> None:
    bodies, joints = _tree(list(range(-1, 30)))
    assert elimination_order(bodies, joints) is joints
