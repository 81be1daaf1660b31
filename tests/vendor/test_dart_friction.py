"""Friction of boxes that slide, by DART's default solver and by its conic one, in dartpy's own words.

Dantzig, the default, bounds friction along two axes apart. The figures are those published of the default settings.
"""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.dart_world import UP, G, dartpy, make_ground, make_mover, make_pose, make_world, moments_of_box

pytestmark = pytest.mark.dart

Floats = NDArray[np.float64]
DT = 1 / 240
SAME = 5e-4
"""The figures are published with four digits; one engine and one scene give them again but for rounding."""


def ready(detector: str, conic: bool) -> Any:
    """A world as it comes but for its detector; `conic` takes the exact cone, solved to 1e-6, and switches sleeping off."""
    world = make_world(detector, DT, sleeping=not conic)
    if conic:
        solver = dartpy.constraint.NsgsFrictionSolver()
        options = solver.getOptions()
        options.tolerance = 1e-6
        solver.setOptions(options)
        world.getConstraintSolver().setBoxedLcpSolver(solver)
    return world


def push(world: Any, name: str, half: Floats, pose: Any, friction: float, velocity: tuple[float, float, float]) -> Any:
    """A box of 1 kg with a velocity [m/s]."""
    box = make_mover(world, dartpy.dynamics.BoxShape(2 * half), pose, name, moments=moments_of_box(half), friction=friction)
    box.getParentJoint().setLinearVelocity(np.array(velocity))
    return box


def plane(world: Any) -> None:
    make_ground(world, dartpy.dynamics.PlaneShape(np.array([0.0, 0.0, 1.0]), 0.0), make_pose(UP, 0.0), friction=1.0)


def forces(world: Any) -> list[tuple[Floats, float, Floats]]:
    """Where each contact is [m], its normal force [N] and its friction [N], on either body."""
    found = []
    for contact in world.getLastCollisionResult().getContacts():
        normal, force = np.array(contact.normal), np.array(contact.force)
        found.append((np.array(contact.point), abs(float(force @ normal)), force - (force @ normal) * normal))
    return found


def around(conic: bool) -> tuple[float, float, float]:
    """Thirteen equal boxes pushed at azimuths from x to y at 2 m/s: (greatest - least)/mean way, the greatest angle [rad]
    between push and way, and the greatest error of a way as a share of v^2/(2 mu g)."""
    world = ready("ode", conic)
    plane(world)
    half, azimuths = np.array([0.1, 0.1, 0.025]), np.linspace(0.0, math.pi / 2, 13)
    boxes = [
        push(world, f"box {k}", half, make_pose(UP, half[2], y=1.6 * k), 0.5, (2 * math.cos(a), 2 * math.sin(a), 0.0))
        for k, a in enumerate(azimuths)
    ]
    for _ in range(180):
        world.step()
    ends = np.array([box.getTransform().translation()[:2] for box in boxes]) - [[0.0, 1.6 * k] for k in range(13)]
    ways = np.linalg.norm(ends, axis=1)
    turned = np.abs(np.arctan2(ends[:, 1], ends[:, 0]) - azimuths)
    return float(np.ptp(ways) / ways.mean()), float(turned.max()), float(np.abs(ways / (4 / G) - 1).max())


def test_by_default_the_way_of_a_push_depends_on_its_azimuth() -> None:
    assert around(conic=False) == pytest.approx((0.3403, 0.2254, 0.3031), rel=SAME)


def test_by_the_conic_solver_it_does_not() -> None:
    # v dt is 2.0 % of the way; half a step at either end, and one before there is a contact.
    spread, turned, way = around(conic=True)
    assert max(spread, turned) < 0.0205
    assert way < 0.031


def stop(conic: bool) -> tuple[float, float]:
    """Boxes that slide along x to a stop, on the weight of all: the greatest sum of |T| - mu N, and of |T + mu N u/|u||."""
    world = ready("ode", conic)
    plane(world)
    half, frictions = np.array([0.2, 0.2, 0.05]), (0.2, 0.4, 0.7)
    boxes = [push(world, f"box {k}", half, make_pose(UP, half[2], y=k), mu, (2.0, 0.0, 0.0)) for k, mu in enumerate(frictions)]
    beyond, askew = 0.0, 0.0
    for _ in range(360):
        world.step()
        over, off = 0.0, 0.0
        for point, normal, rub in forces(world):
            mu, speed = frictions[round(point[1])], boxes[round(point[1])].getCOMLinearVelocity()[0]
            over += max(float(np.linalg.norm(rub)) - mu * normal, 0.0)
            if speed > G * DT:
                off += float(np.linalg.norm(np.abs(rub) - [mu * normal, 0.0, 0.0]))
        beyond, askew = max(beyond, over / (3 * G)), max(askew, off / (3 * G))
    return beyond, askew


def test_by_default_corners_of_a_sliding_box_rub_across_its_way_against_each_other() -> None:
    """Sideways forces that cancel: the box stops rightly, while single forces are beyond mu N and askew to the slip."""
    assert stop(conic=False) == pytest.approx((0.02875, 0.0575), rel=SAME)


def test_by_the_conic_solver_no_corner_rubs_by_more_than_mu_n() -> None:
    # The solver projects on the cone in every sweep, so that whatever is left of its residual lies within it.
    assert stop(conic=True)[0] < 1e-12


STEEPNESS = (0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 1.01, 1.02, 1.03, 1.05, 1.1, 1.2, 1.5)
"""tan(angle)/mu of inclines."""


def incline(conic: bool) -> float:
    """Boxes on inclines for a second, every fourth step: the greatest sum of |T| - mu N over the weight of all."""
    world = ready("fcl", conic)
    half, mu = np.array([0.1, 0.1, 0.025]), 0.5
    for k, steep in enumerate(STEEPNESS):
        angle = math.atan(mu * steep)
        length = 0.5 + max(0.0, G * (math.sin(angle) - mu * math.cos(angle)))
        slab = dartpy.dynamics.BoxShape(np.array([2 * length, 0.6, 0.4]))
        turn = (0.0, angle, 0.0)
        under = make_pose(turn, -0.225 * math.cos(angle), -0.225 * math.sin(angle), k)
        make_ground(world, slab, under, f"incline {k}", friction=mu)
        push(world, f"box {k}", half, make_pose(turn, 0.0, y=k), mu, (0.0, 0.0, 0.0))
    worst = 0.0
    for n in range(240):
        world.step()
        if n % 4 == 3:
            over = sum(max(float(np.linalg.norm(rub)) - mu * normal, 0.0) for _, normal, rub in forces(world))
            worst = max(worst, over / (G * len(STEEPNESS)))
    return worst


def test_by_default_boxes_on_inclines_are_rubbed_by_more_than_mu_n() -> None:
    assert incline(conic=False) == pytest.approx(0.01981, rel=SAME)


def test_by_the_conic_solver_they_are_not() -> None:
    assert incline(conic=True) < 1e-12
