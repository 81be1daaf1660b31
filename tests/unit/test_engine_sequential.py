"""Sequential impulses: the laws of contact that the soft solver keeps, by velocities alone and with depths worked off apart."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from plumbline import engine

G = 9.81
DEFAULT = ("default", "default")
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
DT = 1 / 240
SLOP = 1e-4
"""The depth [m] that is left alone, a tenth of the margin."""


def _ball(radius: float = 0.05, name: str = "ball", **state: object) -> engine.Body:
    return engine.Body(name=name, inertia=0.4 * radius**2 * np.eye(3), shapes=[engine.Placed(engine.Sphere(radius))], **state)  # type: ignore[arg-type]


def _cube(half: float = 0.1, name: str = "cube", mass: float = 1.0, **state: object) -> engine.Body:
    inertia = mass * (2 * half) ** 2 / 6 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Box((half,) * 3))], **state)  # type: ignore[arg-type]


def _world(
    bodies: Sequence[engine.Body], law: engine.Surface | None = None, gravity: Sequence[float] = (0, 0, -G), **options: object
) -> engine.World:
    chosen = {"solver": "sequential_impulses", "substeps": 1, "iterations": 20} | options
    return engine.World(bodies, surfaces={DEFAULT: law or engine.Surface()}, gravity=gravity, options=engine.Options(**chosen))  # type: ignore[arg-type]


def _rough(static: float, kinetic: float | None = None) -> engine.Surface:
    return engine.Surface(static_friction=static, kinetic_friction=static if kinetic is None else kinetic)


def test_a_box_at_rest_stays_where_it_is_and_presses_with_its_weight() -> None:
    """Without springs nothing sinks in: velocities are zero to the sweeps' rounding, and so is the way in two seconds.

    The first step starts from no impulses: of its way g dt^2 = 1.7e-4 m a sweep leaves 0.6, so that 40 leave less than 1e-12 m.
    """
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1), mass=3.0)], _rough(0.5), iterations=40)
    world.step(480)
    assert world.state()[1, :3] == pytest.approx([0, 0, 0.1], abs=1e-12)
    assert np.abs(world.state()[1, 7:]).max() < 1e-9
    found = world.contacts()
    assert found.force.sum(axis=0) == pytest.approx([0.0, 0.0, -3.0 * G], abs=1e-7)


@pytest.mark.parametrize("depth", [1e-3, 5e-3])
def test_a_depth_is_worked_off_by_a_fifth_of_it_in_each_step_and_gives_no_velocity(depth: float) -> None:
    """Beyond the slop, a tenth of the margin, s_k = s_0 (1 - beta)^k with beta = 1/5, since pseudo-velocities are forgotten
    and do not throw the box up. Each sweep over four corners halves what is missing; twenty leave 1e-6 of the work of the first
    step and of its g dt = 4 cm/s.
    """
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1 - SLOP - depth))], _rough(0.5))
    for k in range(1, 20):
        world.step()
        assert 0.1 - SLOP - world.state()[1, 2] == pytest.approx(depth * 0.8**k, rel=1e-6)
        assert np.abs(world.state()[1, 7:10]).max() < 1e-6


@pytest.mark.parametrize("friction", [0.2, 0.7])
def test_a_sliding_box_stops_after_v2_over_2_mu_g_in_every_direction(friction: float) -> None:
    """Semi-implicit Euler goes v_0 dt / 2 = 4 mm less far, to one step's part of a step's way: mu g dt^2 = 1e-4 m.

    The box brakes at its lower side and so leans on its front: the same total, and the direction stays.
    """
    way = 2.0**2 / (2 * friction * G)
    for azimuth in (0.0, 0.4, 1.2):
        start = (2 * math.cos(azimuth), 2 * math.sin(azimuth), 0)
        world = _world([GROUND, _cube(p_WB=(0, 0, 0.1), v_WB=start)], _rough(friction))
        world.step(int(240 * (2.0 / (friction * G) + 1.0)))
        x, y = world.state()[1, :2]
        assert math.hypot(x, y) == pytest.approx(way - 2.0 * DT / 2, abs=friction * G * DT**2 + 1e-3 * way)
        assert math.atan2(y, x) == pytest.approx(azimuth, abs=1e-3)
        assert np.abs(world.state()[1, 7:]).max() < 1e-6


def _incline(tangent: float) -> tuple[float, float, float]:
    angle = math.atan(tangent)
    return G * math.sin(angle), 0.0, -G * math.cos(angle)


def test_static_friction_holds_what_kinetic_friction_would_not() -> None:
    """tan = .55 lies between mu_kinetic = .4 and mu_static = .6. While the sweeps find the load, the box may creep by the way
    that gravity gives in its first steps, 3 g sin dt^2 = 0.25 mm; then it stands.
    """
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.6, 0.4), _incline(0.55))
    world.step(240)
    start = world.state()[1, 0]
    assert abs(start) < 2.5e-4
    world.step(480)
    assert abs(world.state()[1, 0] - start) < 1e-9


def test_beyond_static_friction_a_box_slides_under_kinetic_friction() -> None:
    """tan = .61: v = g (sin - mu_kinetic cos) t; one step under mu_static costs .2 g dt = 7 mm/s of 1.76 m/s."""
    gravity = _incline(0.61)
    world = _world([GROUND, _cube(p_WB=(0, 0, 0.1))], _rough(0.6, 0.4), gravity)
    world.step(240)
    assert world.state()[1, 7] == pytest.approx(gravity[0] + 0.4 * gravity[2], abs=0.01)


@pytest.mark.parametrize("restitution", [0.5, 0.8, 1.0])
def test_a_ball_bounces_with_the_velocity_of_its_impact(restitution: float) -> None:
    """v' = e v, where v is that of the moment of impact to g dt^2 times its share of a step; the flight after it is exact to
    one step of semi-implicit Euler, g dt = 4 cm/s of 4.4 m/s: 1 %.
    """
    world = _world([GROUND, _ball(p_WB=(0, 0, 1.05))], engine.Surface(restitution=restitution), integrator="rk4")
    world.step(160)
    state = world.state()[1]
    energy = G * (state[2] - 0.05) + 0.5 * state[9] ** 2
    assert math.sqrt(energy / G) == pytest.approx(restitution, rel=0.01)
    assert energy <= G * (1 + 1e-12)


def test_a_collision_in_space_keeps_both_momenta() -> None:
    """Impulses are equal, opposite and at one point. Pseudo-velocities move no momentum but the places at which it acts, by the
    depth: a corner turning at 3 rad/s leaves its tangent by w^2 r dt^2 / 2 = 2e-5 m in a step; two bodies, three steps,
    at 1 m/s and with a reduced mass of 2/3 kg: L may change by 1e-4.
    """
    one = _cube(name="one", p_WB=(-0.3, 0.03, 0.02), v_WB=(2.0, 0, 0), w_WB=(1.0, 2.0, 0.5))
    two = _cube(name="two", p_WB=(0.3, 0, 0), v_WB=(-1.0, 0.1, 0), w_WB=(0, -1.0, 3.0), mass=2.0)
    world = _world([one, two], _rough(0.5), (0, 0, 0))

    def momenta() -> np.ndarray:
        s = world.state()
        spin = np.array([[1.0], [2.0]]) * 0.04 / 6 * s[:, 10:]
        p = np.array([[1.0], [2.0]]) * s[:, 7:10]
        return np.concatenate((p.sum(axis=0), (np.cross(s[:, :3], p) + spin).sum(axis=0)))

    before, start = momenta(), world.state().copy()
    world.step(120)
    assert np.abs(world.state()[:, 7:10] - start[:, 7:10]).max() > 0.5
    assert momenta()[:3] == pytest.approx(before[:3], abs=1e-12)
    assert momenta()[3:] == pytest.approx(before[3:], abs=1e-4)


def test_a_stack_of_ten_boxes_stands() -> None:
    """A load goes up and down the stack once per sweep, so that 60 sweeps carry ten boxes to a tenth of a millimetre."""
    stack = [_cube(name=f"box{k}", p_WB=(0, 0, 0.1 + 0.2 * k)) for k in range(10)]
    world = _world([GROUND, *stack], _rough(0.5), iterations=60)
    world.step(720)
    assert np.abs(world.state()[1:, 7:10]).max() < 1e-3
    assert world.contacts().gap.min() > -1e-4
    assert np.abs(world.state()[1:, :2]).max() < 1e-3


def test_more_sweeps_leave_a_smaller_depth() -> None:
    """Gauss-Seidel converges: the stack's largest depth falls with the number of sweeps."""
    depths = []
    for iterations in (5, 15, 45):
        stack = [_cube(name=f"box{k}", p_WB=(0, 0, 0.1 + 0.2 * k)) for k in range(10)]
        world = _world([GROUND, *stack], _rough(0.5), iterations=iterations)
        world.step(480)
        depths.append(-world.contacts().gap.min())
    assert depths[0] > depths[1] > depths[2]


def test_rolling_and_torsional_friction_brake() -> None:
    """a = -(5/7) (b / r) g and I w' = -b m g with the coefficients b [m]; 2 % for the first steps."""
    law = engine.Surface(static_friction=0.8, kinetic_friction=0.8, rolling_friction=0.002)
    world = _world([GROUND, _ball(0.1, p_WB=(0, 0, 0.1), v_WB=(1.0, 0, 0), w_WB=(0, 10.0, 0))], law)
    world.step(240)
    assert 1.0 - world.state()[1, 7] == pytest.approx(5 / 7 * 0.002 / 0.1 * G, rel=0.02)
    law = engine.Surface(static_friction=0.5, kinetic_friction=0.5, torsional_friction=0.001)
    world = _world([GROUND, _ball(0.1, p_WB=(0, 0, 0.1), w_WB=(0, 0, 10.0))], law)
    world.step(240)
    assert 10.0 - world.state()[1, 12] == pytest.approx(0.001 * G / (0.4 * 0.01), rel=0.02)


def test_joints_beside_contacts_are_refused() -> None:
    tied = engine.Ball(name="j", parent=engine.WORLD, child="cube", anchor_W=(0, 0, 2))
    with pytest.raises(engine.NotSupported, match="joints beside contacts"):
        engine.World([GROUND, _cube(p_WB=(0, 0, 1))], [tied], options=engine.Options(solver="sequential_impulses"))
