"""A wheel in a gimbal on DART, in coordinates and on constraints, in dartpy's own words."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.dart_world import dartpy, make_pose, make_world

pytestmark = pytest.mark.dart

CONSTRAINT = dartpy.constraint.DynamicJointConstraint
LEAN = (0.0, spinning.GIMBAL_TILT, 0.0)
AXIS = np.array([math.sin(spinning.GIMBAL_TILT), 0.0, math.cos(spinning.GIMBAL_TILT)])


@pytest.fixture(autouse=True)
def _error_reduction_as_in_ode() -> Iterator[None]:
    """It is one number for all of the process."""
    before = CONSTRAINT.getErrorReductionParameter()
    CONSTRAINT.setErrorReductionParameter(0.2)
    yield
    CONSTRAINT.setErrorReductionParameter(before)


def gimbal(world: Any, wheel: str) -> list[Any]:
    """Rings and wheel on hinges, or the wheel a free body that two points of its axis hold to the inner ring."""
    rings, nodes = dartpy.dynamics.Skeleton("rings"), list[Any]()
    parent: Any = rings
    hinges = [(0.04, spinning.RINGS[0], (1, 0, 0), (0.0, 0.0, 0.0)), (0.03, spinning.RINGS[1], (0, 1, 0), LEAN)]
    if wheel == "coordinates":
        hinges.append((0.3, spinning.WHEEL, (0, 0, 1), (0.0, 0.0, 0.0)))
    for mass, moments, axis, turn in hinges:
        joint, node = parent.createRevoluteJointAndBodyNodePair()
        joint.setAxis(np.array(axis, dtype=float))
        joint.setTransformFromParentBodyNode(make_pose(turn, 0.0))
        node.setInertia(dartpy.dynamics.Inertia(mass, np.zeros(3), np.diag(moments)))
        nodes.append(node)
        parent = node
    rings.setVelocities(np.array(spinning.RATES[: len(nodes)]))
    world.addSkeleton(rings)
    if wheel == "constraint":
        loose = dartpy.dynamics.Skeleton("wheel")
        joint, node = loose.createFreeJointAndBodyNodePair()
        node.setInertia(dartpy.dynamics.Inertia(0.3, np.zeros(3), np.diag(spinning.WHEEL)))
        joint.setTransform(make_pose(LEAN, 0.0))
        loose.setVelocities(np.concatenate((np.array([*spinning.RATES[:2], 0.0]) + spinning.SPIN * AXIS, np.zeros(3))))
        world.addSkeleton(loose)
        for point in (np.zeros(3), 0.1 * AXIS):
            world.getConstraintSolver().addConstraint(dartpy.constraint.BallJointConstraint(nodes[-1], node, point))
        nodes.append(node)
    return nodes


def kept(wheel: str, dt: float) -> tuple[float, float]:
    """The least and the greatest share of its energy within 2 s."""
    world = make_world("fcl", dt)
    world.setGravity((0.0, 0.0, 0.0))
    nodes = gimbal(world, wheel)

    def energy() -> float:
        turns = [np.array(node.getTransform().rotation()) for node in nodes]
        return spinning.gimbal_energy(turns, [np.array(node.getAngularVelocity()) for node in nodes])

    start, shares = energy(), []
    for _ in range(round(2 / dt)):
        world.step()
        shares.append(energy() / start)
    return min(shares), max(share if math.isfinite(share) else math.inf for share in shares)


@pytest.mark.parametrize("dt", [1 / 240, 1e-3, 2.5e-4])
def test_in_coordinates_the_wheels_wobble_takes_energy_from_nowhere(dt: float) -> None:
    # A wobble at 147 rad/s grows by e^(W^2 dt/2) a second: e^2.7 at the finest of these steps, of a thousandth of the energy.
    _, most = kept("coordinates", dt)
    print(f"coordinates at {dt:.5f} s: {most:.3g} times its energy")
    assert most > 2.0


@pytest.mark.parametrize("dt", [1 / 960, 2.5e-4])
def test_on_constraints_in_short_steps_the_wheel_keeps_its_energy(dt: float) -> None:
    least, most = kept("constraint", dt)
    print(f"constraints at {dt:.5f} s: {least:.5g} to {most:.5g} times its energy")
    assert 0.999 < least <= most < 1.001


def test_on_constraints_in_a_step_of_a_240th_the_wheel_loses_half_of_its_energy() -> None:
    least, _ = kept("constraint", 1 / 240)
    print(f"constraints at 1/240 s: {least:.3g} times its energy")
    assert least < 0.5
