"""What pybullet's damping of a body that nobody asked to damp does, in pybullet's own words.

`changeDynamics` documents linearDamping and angularDamping of 0.04 as the default of every body. In the coordinates that
`createMultiBody` makes they act as 0.04 (1 + |v|) a second. Each test lets a user's scene run as it comes, and again with both
set to zero: the figures are those that are published of the default settings, and without damping each is gone.
"""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G = 9.81
DT = 1 / 240
Floats = NDArray[np.float64]
SAME = 5e-4
"""The figures are published with four digits; one engine and one scene give them again but for rounding."""


def undamp(world: World, body: int, damped: bool) -> None:
    if not damped:
        world.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)


@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0])
def test_the_damping_of_0_04_acts_as_0_04_times_one_plus_the_speed(world: World, speed: float) -> None:
    """v' = -0.04 v (1 + v) takes v/(1 + v) to e^(-0.04 t) of itself; plain damping of 0.04 would take v there."""
    ball = world.createMultiBody(baseMass=1.0)
    world.resetBaseVelocity(ball, [speed, 0, 0])
    for _ in range(240):
        world.stepSimulation()
    share = speed / (1 + speed) * math.exp(-0.04)
    # The step is explicit: 0.04 (1 + v) dt of what is lost, 0.2 % at 10 m/s.
    assert speed - world.getBaseVelocity(ball)[0][0] == pytest.approx(speed - share / (1 - share), rel=2.5e-3)


def spun(world: World, maximal: int, seconds: float, **dynamics: float) -> float:
    """The spin [rad/s] of a cube alone in space, so long after it turned at 4 rad/s about its z axis."""
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1] * 3)
    cube: int = world.createMultiBody(1.0, shape, useMaximalCoordinates=maximal)
    world.changeDynamics(cube, -1, **dynamics)
    world.resetBaseVelocity(cube, [0, 0, 0], [0, 0, 4.0])
    for _ in range(round(seconds / DT)):
        world.stepSimulation()
    return float(world.getBaseVelocity(cube)[1][2])


@pytest.mark.parametrize("seconds", [1.5, 10.0])
def test_a_spin_that_nothing_touches_decays_by_the_same_law(world: World, seconds: float) -> None:
    # dw/dt = -k w (1 + w) in rad/s with k = 0.04, whose solution is w/(1 + w) = w0/(1 + w0) exp(-k t): 3.055 rad/s after 1.5 s.
    share = 4 / 5 * math.exp(-0.04 * seconds)
    # Explicit Euler departs from it by k (1 + 2 w0) dt/2 = 0.08 % at most.
    assert spun(world, MULTIBODY, seconds) == pytest.approx(share / (1 - share), rel=1e-3)


@pytest.mark.parametrize(
    ("maximal", "dynamics"),
    [(MULTIBODY, {"linearDamping": 0.0, "angularDamping": 0.0}), (MAXIMAL, {})],
    ids=["multibody, set to nought", "maximal, by default"],
)
def test_a_spin_stays_where_nothing_damps(world: World, maximal: int, dynamics: dict[str, float]) -> None:
    # Double precision over 2400 steps, at worst one way: 2400 * 1e-16 = 3e-13.
    assert spun(world, maximal, 10.0, **dynamics) == pytest.approx(4.0, rel=1e-9)


def fly(world: World, damped: bool) -> tuple[float, float, float]:
    """Greatest errors of position [m], velocity [m/s] and of the energy, a share of the largest kinetic one, in 2 s."""
    world.setGravity(0, 0, -G)
    ball = world.createMultiBody(baseMass=1.0)
    undamp(world, ball, damped)
    start = np.array([3.0, 1.0, 8.0])
    world.resetBaseVelocity(ball, start.tolist())
    off = np.zeros(3)
    largest = max(start @ start, 10.0 + (G * 2.0 - 8.0) ** 2) / 2
    for n in range(1, round(2 / DT) + 1):
        world.stepSimulation()
        t = n * DT
        x, v = np.array(world.getBasePositionAndOrientation(ball)[0]), np.array(world.getBaseVelocity(ball)[0])
        pull = np.array([0.0, 0.0, -G])
        energy = v @ v / 2 + G * x[2] - start @ start / 2
        here = [np.linalg.norm(x - start * t - pull * t**2 / 2), np.linalg.norm(v - start - pull * t), abs(energy) / largest]
        off = np.maximum(off, here)
    return float(off[0]), float(off[1]), float(off[2])


def test_a_thrown_ball_is_braked_on_its_way(world: World) -> None:
    assert fly(world, damped=True) == pytest.approx((1.449, 2.051, 0.3618), rel=SAME)


def test_a_thrown_ball_follows_its_parabola_without_damping(world: World) -> None:
    position, velocity, energy = fly(world, damped=False)
    # Semi-implicit Euler errs by g dt t/2 in position, its velocity is exact, and g times that misses in energy.
    assert position == pytest.approx(G * DT, rel=1e-6)
    assert velocity < 1e-12
    assert energy == pytest.approx(G * G * DT / 72.49, rel=1e-3)


def tumble(world: World, damped: bool) -> tuple[float, float]:
    """The shares of angular momentum and of energy by which a free top departs from its start within 10 s."""
    top = world.createMultiBody(baseMass=6.0)
    inertia, spin = np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.7, 1.2])
    world.changeDynamics(top, -1, localInertiaDiagonal=inertia.tolist())
    undamp(world, top, damped)
    world.resetBaseVelocity(top, [0, 0, 0], spin.tolist())
    momentum, energy, off = inertia * spin, spin @ (inertia * spin) / 2, np.zeros(2)
    for _ in range(round(10 / DT)):
        world.stepSimulation()
        turn = world.getBasePositionAndOrientation(top)[1]
        R = np.array(world.getMatrixFromQuaternion(turn)).reshape(3, 3)
        w = R.T @ np.array(world.getBaseVelocity(top)[1])
        lost = np.linalg.norm(R @ (inertia * w) - momentum) / np.linalg.norm(momentum)
        off = np.maximum(off, [lost, abs(w @ (inertia * w) / 2 / energy - 1)])
    return float(off[0]), float(off[1])


def test_a_free_top_loses_half_of_its_angular_momentum_in_ten_seconds(world: World) -> None:
    assert tumble(world, damped=True) == pytest.approx((0.5497, 0.7968), rel=SAME)


def test_a_free_top_without_damping_errs_by_its_integrator_alone(world: World) -> None:
    # Explicit gyroscopic terms gain in energy about dt times the rate at which the rates change, 1.3 % in 10 s.
    momentum, energy = tumble(world, damped=False)
    assert momentum < 0.01
    assert energy < 0.02


@pytest.mark.parametrize(("damped", "left"), [(True, 0.0), (False, 2.0)])
def test_a_ball_that_spins_in_empty_space_has_stopped_after_200_s(world: World, damped: bool, left: float) -> None:
    """A gyroscope on it is 2 rad/s off then, an accelerometer 0.3 m off its axis w^2 r = 1.2 m/s2."""
    world.setTimeStep(1 / 120)
    ball = world.createMultiBody(baseMass=1.0)
    world.changeDynamics(ball, -1, localInertiaDiagonal=[0.1] * 3)
    undamp(world, ball, damped)
    world.resetBaseVelocity(ball, [0, 0, 0], [0, 0, 2.0])
    for _ in range(200 * 120):
        world.stepSimulation()
    spin = world.getBaseVelocity(ball)[1][2]
    assert spin == pytest.approx(left, abs=1e-3)
    assert 0.3 * (4.0 - spin**2) == pytest.approx(1.2 if damped else 0.0, abs=1e-3)


def hang(world: World, angles: Sequence[float], length: float, thickness: float, damped: bool) -> int:
    """Rods of 1 kg on hinges about y, one under the other, at rest at angles [rad] from the vertical."""
    rods, half = len(angles), thickness / 2
    chain: int = world.createMultiBody(
        baseMass=0.0,
        linkMasses=[1.0] * rods,
        linkCollisionShapeIndices=[-1] * rods,
        linkVisualShapeIndices=[-1] * rods,
        linkPositions=[[0.0, 0.0, -length * (k > 0)] for k in range(rods)],
        linkOrientations=[[0, 0, 0, 1]] * rods,
        linkInertialFramePositions=[[0.0, 0.0, -length / 2]] * rods,
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * rods,
        linkParentIndices=list(range(rods)),
        linkJointTypes=[pybullet.JOINT_REVOLUTE] * rods,
        linkJointAxis=[[0, -1, 0]] * rods,
    )
    across = (length**2 + thickness**2) / 12
    for k in range(rods):
        world.changeDynamics(chain, k, localInertiaDiagonal=[across, across, (2 * half) ** 2 / 6])
        # The motor that pybullet puts on every hinge is off.
        world.setJointMotorControl2(chain, k, pybullet.VELOCITY_CONTROL, force=0)
        world.resetJointState(chain, k, angles[k] - (angles[k - 1] if k else 0.0), 0.0)
    undamp(world, chain, damped)
    world.setGravity(0, 0, -G)
    return chain


def swing(world: World, damped: bool) -> tuple[float, float]:
    """Greatest errors of position [m] and of the energy, a share of that in play, of a rod let go at 30 degrees, in 10 s."""
    start, inertia = math.radians(30), (1 + 0.1**2) / 12 + 0.25
    rod = hang(world, [start], 1.0, 0.1, damped)
    rate, k = math.sqrt(G * 0.5 / inertia), math.sin(start / 2)
    energy, off, lost = -G * 0.5 * math.cos(start), 0.0, 0.0
    for n in range(1, round(10 / DT) + 1):
        world.stepSimulation()
        angle, speed = world.getJointState(rod, 0)[:2]
        true = 2 * math.asin(k * ellipj(ellipk(k * k) - rate * n * DT, k * k)[0])
        off = max(off, abs(math.sin((angle - true) / 2)))
        lost = max(lost, abs(inertia * speed**2 / 2 - G * 0.5 * math.cos(angle) - energy))
    return off, lost / (G * 0.5 * (1 - math.cos(start)))


def test_a_pendulum_loses_half_of_its_energy_in_ten_seconds(world: World) -> None:
    assert swing(world, damped=True) == pytest.approx((0.08694, 0.5252), rel=SAME)


def test_a_pendulum_keeps_time_and_energy_without_damping(world: World) -> None:
    # Half a step between position and velocity: v dt/2 at the largest speed, 0.98 m/s, and w0 dt/2 of the energy in play.
    position, energy = swing(world, damped=False)
    assert position == pytest.approx(0.98 * DT / 2, rel=0.1)
    assert energy == pytest.approx(math.sqrt(1.5 * G) * DT / 2, rel=0.02)


def swing_two(world: World, damped: bool) -> float:
    """The greatest error [m] of the centres of two rods let go at 20 and 30 degrees, in 5 s, against Lagrange's equations."""
    length, d, start = 0.5, 0.25, np.radians([20.0, 30.0])
    chain = hang(world, start.tolist(), length, 0.05, damped)
    own, coupling = (length**2 + 0.05**2) / 12 + d * d, length * d

    def change(_t: float, y: Floats) -> Floats:
        apart = y[0] - y[1]
        matrix = np.array([[own + length**2, coupling * math.cos(apart)], [coupling * math.cos(apart), own]])
        pull = [-(d + length) * G * math.sin(y[0]), -d * G * math.sin(y[1])]
        turn = [-coupling * math.sin(apart) * y[3] ** 2, coupling * math.sin(apart) * y[2] ** 2]
        return np.concatenate([y[2:], np.linalg.solve(matrix, np.add(pull, turn))])

    def places(upper: float, lower: float) -> Floats:
        top = np.array([math.sin(upper), -math.cos(upper)])
        return np.array([d * top, length * top + d * np.array([math.sin(lower), -math.cos(lower)])])

    times = np.arange(round(5 / DT) + 1) * DT
    true = solve_ivp(change, (0, times[-1]), [*start, 0, 0], "DOP853", t_eval=times, rtol=1e-10, atol=1e-11).y
    off = 0.0
    for k in range(1, len(times)):
        world.stepSimulation()
        upper, bend = world.getJointState(chain, 0)[0], world.getJointState(chain, 1)[0]
        off = max(off, *np.linalg.norm(places(upper, upper + bend) - places(true[0, k], true[1, k]), axis=1))
    return off


def test_a_double_pendulum_is_centimetres_off_within_five_seconds(world: World) -> None:
    assert swing_two(world, damped=True) == pytest.approx(0.05172, rel=SAME)


def test_a_double_pendulum_without_damping_errs_by_half_a_step(world: World) -> None:
    # The lower rod's centre goes 1.2 m/s at most; half a step of it is 2.5 mm.
    assert swing_two(world, damped=False) < 0.003


def lay(world: World, half: Sequence[float], pushes: Floats, frictions: Sequence[float], damped: bool) -> list[int]:
    """Boxes of 1 kg side by side on a box like that of plane.urdf, each with a push [m/s] and a coefficient of friction."""
    world.setGravity(0, 0, -G)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[100.0, 100.0, 5.0], collisionFramePosition=[0, 0, -5])
    ground: int = world.createMultiBody(0.0, slab)
    world.changeDynamics(ground, -1, lateralFriction=1.0)
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
    boxes = []
    for k, (push, friction) in enumerate(zip(pushes, frictions, strict=True)):
        box = world.createMultiBody(1.0, shape, basePosition=[0, 2 * k, half[2]])
        world.changeDynamics(box, -1, lateralFriction=friction)
        undamp(world, box, damped)
        world.resetBaseVelocity(box, [*push, 0.0])
        boxes.append(box)
    return boxes


def slide(
    world: World, half: Sequence[float], pushes: Floats, frictions: Sequence[float], damped: bool, until: float
) -> tuple[float, float]:
    """The greatest errors of way and of the time to a tenth of the speed, as shares of the true ones, `until` [s]."""
    boxes = lay(world, half, pushes, frictions, damped)
    speeds = [np.linalg.norm(pushes, axis=1)]
    for _ in range(round(until / DT)):
        world.stepSimulation()
        speeds.append(np.array([math.hypot(*world.getBaseVelocity(box)[0][:2]) for box in boxes]))
    speed, ways, times = np.array(speeds), [], []
    for k, box in enumerate(boxes):
        x, y, _ = world.getBasePositionAndOrientation(box)[0]
        ways.append(math.hypot(x, y - 2 * k) / (2.0**2 / (2 * frictions[k] * G)) - 1)
        last = int(np.flatnonzero(speed[:, k] <= 0.2)[0])
        share = (speed[last - 1, k] - 0.2) / (speed[last - 1, k] - speed[last, k])
        times.append((last - 1 + share) * DT / (1.8 / (frictions[k] * G)) - 1)
    return max(map(abs, ways)), max(map(abs, times))


ALONG = np.array([[2.0, 0.0]] * 3)
AROUND = np.array([[2 * math.cos(a), 2 * math.sin(a)] for a in np.linspace(0, math.pi / 2, 13)])
"""Pushes [m/s] along x, and at thirteen azimuths from x to y."""


def test_sliding_boxes_stop_early(world: World) -> None:
    found = slide(world, (0.2, 0.2, 0.05), ALONG, (0.2, 0.4, 0.7), damped=True, until=1.5)
    assert found == pytest.approx((0.06708, 0.04923), rel=SAME)


def test_boxes_stop_early_in_every_direction(world: World) -> None:
    found = slide(world, (0.1, 0.1, 0.025), AROUND, [0.5] * 13, damped=True, until=0.75)
    assert found[0] == pytest.approx(0.03678, rel=SAME)


def test_sliding_boxes_stop_on_time_without_damping(world: World) -> None:
    # Half a step's way is 1.4 % of the shortest one, a step 2.2 % of the shortest time to a tenth of the speed.
    way, time = slide(world, (0.2, 0.2, 0.05), ALONG, (0.2, 0.4, 0.7), damped=False, until=1.5)
    assert way < 0.0143
    assert time < 0.0227


def test_boxes_stop_where_coulomb_says_in_every_direction_without_damping(world: World) -> None:
    # Half a step's way, v dt/2, is 1.0 % of v^2/(2 mu g).
    assert slide(world, (0.1, 0.1, 0.025), AROUND, [0.5] * 13, damped=False, until=0.75)[0] < 0.0103


def missed(world: World, damped: bool) -> float:
    """The greatest |m dv - (F + m g) dt| of a step of three boxes that slide to a stop, over the greatest m |dv|."""
    boxes = lay(world, (0.2, 0.2, 0.05), ALONG, (0.2, 0.4, 0.7), damped)
    before, off, gained = [np.array([2.0, 0.0, 0.0]) for _ in boxes], 0.0, 0.0
    for _ in range(360):
        world.stepSimulation()
        points = world.getContactPoints()
        for k, box in enumerate(boxes):
            force = np.array([0.0, 0.0, -G])
            for c in (c for c in points if box in c[1:3]):
                sign = 1 if c[1] == box else -1
                force += sign * (c[9] * np.array(c[7]) + c[10] * np.array(c[11]) + c[12] * np.array(c[13]))
            v = np.array(world.getBaseVelocity(box)[0])
            off = max(off, float(np.linalg.norm(v - before[k] - force * DT)))
            gained, before[k] = max(gained, float(np.linalg.norm(v - before[k]))), v
    return off / gained


def test_what_a_sliding_box_loses_is_more_than_its_contacts_take(world: World) -> None:
    assert missed(world, damped=True) == pytest.approx(0.03189, rel=SAME)


def test_contacts_take_all_that_a_sliding_box_loses_without_damping(world: World) -> None:
    # Forces and motion are two readings of one solve.
    assert missed(world, damped=False) < 1e-6


def swung(world: World, dry: float, *, damped: bool) -> float:
    """The angle [rad] of a bar of 2 kg with its centre 0.25 m off its hinge, two seconds after it was let go level, braked by
    `dry` [N m]."""
    world.setGravity(0.0, 0.0, -G)
    bar: int = world.createMultiBody(
        baseMass=0, linkMasses=[2.0], linkCollisionShapeIndices=[-1], linkVisualShapeIndices=[-1], linkPositions=[[0] * 3],
        linkOrientations=[[0, 0, 0, 1]], linkInertialFramePositions=[[0.25, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0], linkJointTypes=[pybullet.JOINT_REVOLUTE],
        linkJointAxis=[[0, 1, 0]],
    )  # fmt: skip
    world.changeDynamics(bar, 0, localInertiaDiagonal=[0.01, 0.05, 0.05])
    undamp(world, bar, damped)
    world.setJointMotorControl2(bar, 0, pybullet.VELOCITY_CONTROL, targetVelocity=0.0, force=dry)
    for _ in range(round(2.0 / DT)):
        world.stepSimulation()
    return float(world.getJointState(bar, 0)[0])


@pytest.mark.parametrize("dry", [0.0, 0.5])
def test_an_arm_with_dry_friction_ends_where_coulomb_says_without_damping_and_not_with_it(world: World, dry: float) -> None:
    # x'' = (m g l cos x - T sign(x')) / I, whose sign is smoothed over a millionth of a radian a second.
    moment = 0.05 + 2.0 * 0.25**2

    def rate(_: float, y: Sequence[float]) -> list[float]:
        return [y[1], (2.0 * G * 0.25 * math.cos(y[0]) - dry * math.tanh(y[1] / 1e-6)) / moment]

    law = float(solve_ivp(rate, (0.0, 2.0), [0.0, 0.0], method="LSODA", rtol=1e-8, atol=1e-10).y[0, -1])
    # Semi-implicit Euler errs by half a step of the motion: 2.8 rad/s for 1/480 s.
    assert swung(world, dry, damped=False) == pytest.approx(law, abs=6e-3)
    # 0.04 (1 + |v|) v takes 0.13 rad of it in two swings, with and without dry friction.
    assert law - swung(world, dry, damped=True) > 0.12
