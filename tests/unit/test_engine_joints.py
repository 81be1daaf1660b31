"""Joints: pendulums against an independent integrator, closed loops, limits, springs and drives."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from plumbline import engine

pytestmark = pytest.mark.usefixtures("both_coordinates")

G = 9.81


def _pendulum(inertia: float, angle: float = math.pi / 2, **options: object) -> engine.World:
    """A body of 1 kg, 1 m below a hinge about y, raised by `angle` from hanging."""
    p = (math.sin(angle), 0.0, -math.cos(angle))
    body = engine.Body(name="bob", inertia=inertia * np.eye(3), p_WB=p)
    hinge = engine.Revolute(name="hinge", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0), axis_W=(0, 1, 0))
    return engine.World([body], [hinge], options=engine.Options(**options))  # type: ignore[arg-type]


def _energy(state: np.ndarray, inertia: float) -> float:
    return float(0.5 * state[7:10] @ state[7:10] + 0.5 * inertia * state[10:] @ state[10:] + G * state[2])


@pytest.mark.parametrize("inertia", [1e-3, 1 / 12])
def test_a_pendulum_under_runge_kutta_keeps_energy_and_length(inertia: float) -> None:
    """Order four at w dt = 4.4/240 with w the greatest rate: (w dt)^4 / 120 = 1e-9 a radian, some 30 radians in 10 s."""
    world = _pendulum(inertia, integrator="rk4")
    worst = gap = 0.0
    for _ in range(2400):
        world.step()
        state = world.state()[0]
        worst = max(worst, abs(_energy(state, inertia)) / G)
        gap = max(gap, abs(math.hypot(state[0], state[2]) - 1.0))
    assert worst < 3e-8
    assert gap < 1e-14


def test_a_pendulum_under_runge_kutta_follows_the_true_path() -> None:
    """Same estimate as for the energy: 3e-8 rad, against an integrator of order eight."""
    world = _pendulum(1 / 12, integrator="rk4")
    world.step(2400)
    end = solve_ivp(
        lambda _, y: [y[1], -G * math.sin(y[0]) / (13 / 12)], (0, 10), [math.pi / 2, 0], method="DOP853", rtol=1e-13, atol=1e-14
    ).y[0, -1]
    x, _, z = world.state()[0, :3]
    assert math.atan2(x, -z) == pytest.approx(end, abs=3e-8)


def test_a_pendulum_under_shake_has_a_bounded_energy_error() -> None:
    """SHAKE is symplectic: raw energy swings by h v g at most (h = 1/960 s, v = 4.4 m/s: .005 of m g L) and does not drift."""
    world = _pendulum(1e-3)
    errors = []
    for _ in range(2400):
        world.step()
        errors.append(_energy(world.state()[0], 1e-3) / G)
    swing = np.abs(errors)
    assert swing.max() < 0.005
    assert abs(swing[-600:].max() - swing[:600].max()) < 2e-4


def test_the_period_of_a_ten_degree_swing_is_the_elliptic_integral() -> None:
    """T = 4 K(sin^2(th/2)) sqrt(I/(m g L)): after one period the angle is back; its error is second order in the time error."""
    inertia, angle = 1e-3, math.radians(10)
    period = 4 * ellipk(math.sin(angle / 2) ** 2) * math.sqrt((1 + inertia) / G)
    world = _pendulum(inertia, angle, dt=period / 480, integrator="rk4")
    world.step(480 // 4)
    assert math.atan2(world.state()[0, 0], -world.state()[0, 2]) == pytest.approx(0.0, abs=1e-8)


def test_a_closed_loop_with_redundant_rows_stays_closed() -> None:
    """A parallelogram of four hinges has three rows too many; they are left out and the gap stays at round-off."""

    def bar(name: str, p: tuple[float, float, float]) -> engine.Body:
        return engine.Body(name=name, inertia=0.05 * np.eye(3), p_WB=p)

    def hinge(name: str, parent: str, child: str, x: float, z: float) -> engine.Revolute:
        return engine.Revolute(name=name, parent=parent, child=child, anchor_W=(x, 0, z), axis_W=(0, 1, 0))

    bodies = [bar("left", (0.25, 0, -0.433)), bar("coupler", (1.0, 0, -0.866)), bar("right", (1.25, 0, -0.433))]
    joints = [
        hinge("a", engine.WORLD, "left", 0.0, 0.0),
        hinge("b", "left", "coupler", 0.5, -0.866),
        hinge("c", "coupler", "right", 1.5, -0.866),
        hinge("d", engine.WORLD, "right", 1.0, 0.0),
    ]
    world = engine.World(bodies, joints, options=engine.Options(integrator="rk4"))
    energy = []
    for _ in range(480):
        world.step()
        s = world.state()
        energy.append(sum(_energy(row, 0.05) for row in s))
    assert np.ptp(energy) < 1e-6
    s = world.state()
    assert s[2, :3] - s[0, :3] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert s[1, 3:7] == pytest.approx([1, 0, 0, 0], abs=1e-12)


@pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
def test_a_limit_stops_a_swing(integrator: str) -> None:
    """The rate is cut so that the next step ends on the limit; it may overshoot by what gravity adds in one step, g dt^2 =
    2e-4.

    """
    body = engine.Body(name="bob", inertia=1e-3 * np.eye(3), p_WB=(1.0, 0.0, 0.0))
    hinge = engine.Revolute(
        name="hinge", parent=engine.WORLD, child="bob", anchor_W=(0, 0, 0), axis_W=(0, 1, 0), limits=engine.Limits(upper=0.5)
    )
    world = engine.World([body], [hinge], options=engine.Options(integrator=integrator))
    world.step(480)
    angle = math.atan2(-world.state()[0, 2], world.state()[0, 0])
    assert angle == pytest.approx(0.5, abs=5e-4)
    assert np.abs(world.state()[0, 7:]).max() < 0.05


def _slider(integrator: str, **extras: object) -> engine.World:
    body = engine.Body(name="block", mass=2.0, p_WB=(0.3, 0.0, 0.0))
    rail = engine.Prismatic(
        name="rail",
        parent=engine.WORLD,
        child="block",
        anchor_W=(0, 0, 0),
        axis_W=(1, 0, 0),
        position=0.3,
        **extras,  # type: ignore[arg-type]
    )
    return engine.World([body], [rail], options=engine.Options(integrator=integrator))


def test_a_spring_swings_as_the_closed_form_says() -> None:
    """m = 2 kg, k = 50 N/m, zeta = .1: explicit stages of order four, (w dt)^5 / 120 a step: below 1e-8 m in 2 s."""
    k, m, x0 = 50.0, 2.0, 0.2
    w0 = math.sqrt(k / m)
    c = 0.2 * math.sqrt(k * m)
    world = _slider("rk4", spring=engine.Spring(stiffness=k, damping=c, rest=0.1))
    world.step(480)
    wd, decay = w0 * math.sqrt(1 - 0.01), 0.1 * w0
    x = x0 * math.exp(-decay * 2) * (math.cos(wd * 2) + decay / wd * math.sin(wd * 2))
    assert world.state()[0, 0] == pytest.approx(0.1 + x, abs=1e-8)


@pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
def test_a_stiff_drive_is_stable_and_reaches_its_target(integrator: str) -> None:
    """k = 1e6 N/m at dt = 1/240: dt sqrt(k/m) = 3 is beyond explicit schemes; the implicit one settles on the target."""
    world = _slider(integrator, drive=engine.Drive(stiffness=1e6, damping=1e3, target=0.5))
    world.step(240)
    assert world.state()[0, 0] == pytest.approx(0.5, abs=1e-6)
    world.command("rail", -0.2)
    world.step(240)
    assert world.state()[0, 0] == pytest.approx(-0.2, abs=1e-6)


@pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
def test_a_drive_gives_no_more_than_its_limit(integrator: str) -> None:
    """4 N on 2 kg for 1 s: 2 m/s, to round-off, while the target is far away."""
    world = _slider(integrator, drive=engine.Drive(stiffness=1e6, damping=1e3, target=100.0, limit=4.0))
    world.step(240)
    assert world.state()[0, 7] == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize("integrator", ["rk4", "semi_implicit_euler"])
def test_a_fixed_pair_moves_as_one(integrator: str) -> None:
    """Two spinning bodies fixed together keep their relative pose to round-off of positions of 10 m: 1e-12."""
    one = engine.Body(name="one", inertia=0.1 * np.eye(3), p_WB=(-0.5, 0, 0), v_WB=(0, -0.5, 0), w_WB=(0, 0, 1))
    two = engine.Body(name="two", inertia=0.1 * np.eye(3), p_WB=(0.5, 0, 0), v_WB=(0, 0.5, 0), w_WB=(0, 0, 1))
    world = engine.World(
        [one, two], [engine.Fixed(name="weld", parent="one", child="two")], options=engine.Options(integrator=integrator)
    )
    world.step(240)
    s = world.state()
    assert np.linalg.norm(s[1, :3] - s[0, :3]) == pytest.approx(1.0, abs=1e-12)
    assert s[0, 3:7] == pytest.approx(s[1, 3:7], abs=1e-12)


def test_a_driven_arm_on_a_standing_box_is_carried_by_the_ground() -> None:
    """At rest the ground carries both weights, to the round-off of a settled warm start, and the drive holds the arm's moment.

    The arm of 1 kg reaches .3 m to the side: k (target - x) = m g l cos x is 2.9 N m, so x stays .0029 rad below the target.
    """
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    base = engine.Body(
        name="base", mass=4.0, inertia=0.1 * np.eye(3), shapes=[engine.Placed(engine.Box((0.3, 0.3, 0.1)))], p_WB=(0, 0, 0.1)
    )
    arm = engine.Body(
        name="arm", inertia=0.01 * np.eye(3), shapes=[engine.Placed(engine.Capsule(0.03, 0.1))], p_WB=(0.3, 0, 0.4)
    )
    elbow = engine.Revolute(
        name="elbow",
        parent="base",
        child="arm",
        anchor_W=(0, 0, 0.4),
        axis_W=(0, -1, 0),
        drive=engine.Drive(stiffness=1000.0, damping=50.0),
    )
    law = engine.Surface(static_friction=0.8, kinetic_friction=0.8)
    world = engine.World([ground, base, arm], [elbow], surfaces={("default", "default"): law})
    world.step(720)
    state = world.state()
    assert -world.contacts().force[:, 2].sum() == pytest.approx(5 * G, rel=1e-6)
    assert np.abs(state[1:, 7:]).max() < 1e-5
    angle = math.atan2(state[2, 2] - state[1, 2] - 0.3, state[2, 0] - state[1, 0])
    assert angle == pytest.approx(-G * 0.3 / 1000, rel=0.02)
