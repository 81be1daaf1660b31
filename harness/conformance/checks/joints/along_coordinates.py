"""Checks of what acts along a joint's coordinate: drives, rotor inertia, dry friction, speed limit, the tie to another one."""

from math import cos, exp, sin
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Comparisons, check, firm, near
from plumbline.harness.conformance.closed_forms import pendulum_end, swing
from plumbline.harness.conformance.engine import Engine, state_of
from plumbline.harness.conformance.frames import ORIGIN, TURNED, X, Y, Z, aligned, vector
from plumbline.harness.conformance.scenes import G, free, prismatic, revolute, without_gravity
from plumbline.harness.scene import Body, Coupling, Drive, Prismatic, Scene, Vector3, axis_angle


def _driven(*drives: Drive) -> Scene:
    """Bodies of 2 kg beside each other, each on a slide along x with its drive, without gravity."""
    return without_gravity(
        *(free(f"body{k}", p=(0.0, 3.0 * k, 0.0)) for k in range(len(drives))),
        joints=tuple(prismatic(f"slide{k}", f"body{k}", (0.0, 3.0 * k, 0.0), X, drive=drive) for k, drive in enumerate(drives)),
    )


@check("Does a drive's target velocity act, alone and beside its target?", Feature.PRISMATIC | Feature.DRIVES)
def target_velocity_acts(engine: Engine) -> Comparisons:
    """Without stiffness v = u (1 - e^(-c t/m)); with stiffness k as well, the body rests at target + c u/k."""
    c, u, t, m = 8.0, 0.5, 0.3, 2.0
    rest = Drive(stiffness=200.0, damping=60.0, target=0.1, target_velocity=u)
    scene = _driven(Drive(damping=c, target_velocity=u), rest)
    early, late = (engine.final(scene, time) for time in (t, 3.0))
    expected = u * (1 - exp(-c * t / m))
    yield near("speed under c (u - v) after .3 s [m/s]", early.v_WB[0, 0], expected, 5e-3, "c u/m dt, and default damping")
    yield near("place at rest under k (x0 - x) + c u [m]", late.p_WB[1, 0], 0.1 + 60.0 * u / 200.0, 2e-3, "both terms balance")


@firm("Does a command reach every drive that it names, and no other?", Feature.PRISMATIC | Feature.DRIVES)
def command_reaches_every_drive(engine: Engine) -> Comparisons:
    """Three drives at 0; the last two are sent off, then the first alone."""
    scene = _driven(*(Drive(stiffness=200.0, damping=40.0) for _ in range(3)))
    with engine.built(scene) as simulation:
        simulation.command({"slide2": 0.3, "slide1": -0.2})
        simulation.step(1500)
        first = state_of(simulation, scene).p_WB[:, 0]
        simulation.command({"slide0": 0.1})
        simulation.step(1500)
        second = state_of(simulation, scene).p_WB[:, 0]
    yield near("places after a command to the last two [m]", first, (0.0, -0.2, 0.3), 2e-3, "e^(-10 t) has died out")
    yield near("places after a command to the first [m]", second, (0.1, -0.2, 0.3), 2e-3, "the others keep their targets")


@check(
    "Does a constant force in a drive's law act, alone, beside the PD law and within the limit?",
    Feature.PRISMATIC | Feature.DRIVES | Feature.FEEDFORWARD,
)
def feedforward_acts(engine: Engine) -> Comparisons:
    """Motors of 1.5 N, one of them cut off at 1 N; one beside a damper; one beside a PD law, before and after a command."""
    t, m, c = 0.3, 2.0, 8.0
    scene = _driven(
        Drive(feedforward=1.5),
        Drive(feedforward=-1.5, limit=1.0),
        Drive(damping=c, target_velocity=0.2, feedforward=1.5),
        Drive(stiffness=200.0, damping=40.0, target=0.1, feedforward=6.0),
    )
    with engine.built(scene) as simulation:
        simulation.step(300)
        early = state_of(simulation, scene).v_WB[:3, 0]
        simulation.step(1200)
        first = float(state_of(simulation, scene).p_WB[3, 0])
        simulation.command({"slide3": -0.1})
        simulation.step(1500)
        second = float(state_of(simulation, scene).p_WB[3, 0])
    speeds = (1.5 * t / m, -1.0 * t / m, (0.2 + 1.5 / c) * (1 - exp(-c * t / m)))
    yield near("speeds after .3 s under a motor, a limited one and a damped one [m/s]", early, speeds, 5e-3, "f t/m, 2 %")
    yield near("place at rest under k (x0 - x) + b [m]", first, 0.1 + 6.0 / 200.0, 2e-3, "e^(-10 t) has died out")
    yield near("place after the command to -.1 [m]", second, -0.1 + 6.0 / 200.0, 2e-3, "a command leaves the push as it is")


@check(
    "Does a motor between two bodies turn both, about the joint's axis and against each other?",
    Feature.REVOLUTE | Feature.DRIVES | Feature.FEEDFORWARD,
)
def motor_turns_two_bodies(engine: Engine) -> Comparisons:
    """A motor between two wheels about a slanted axis: opposite turns about that axis, each of tau t/I; the hub rests."""
    axis, tau, t = (2.0 / 3, -1.0 / 3, 2.0 / 3), 0.6, 0.3
    bodies = (free("stator", moments=(0.6, 0.6, 0.6)), free("rotor", moments=(0.3, 0.3, 0.3), q=TURNED))
    hub = revolute("hub", "rotor", ORIGIN, axis, drive=Drive(feedforward=tau), parent="stator")
    end = engine.final(without_gravity(*bodies, joints=(hub,)), t)
    expected = [[-tau * t / 0.6 * c for c in axis], [tau * t / 0.3 * c for c in axis]]
    yield near("angular velocities [rad/s]", end.w_WB, expected, 0.02, "tau t/I and no more; 3 % for default damping")
    yield near("places of both [m]", end.p_WB, [[0.0] * 3] * 2, 1e-6, "a couple moves no centre of mass")


_HALF_A_STEP = 5e-3
"""A staggered scheme of first order is off by v dt/2, at most 1.5 mm at 3 m/s and 1 ms; what is soft gives as much."""


def _hanging(name: str, angle: float, top: Vector3 = ORIGIN, mass: float = 2.0, moment: float = 0.2) -> Body:
    """A rod of 1 m below `top` at rest, turned about y by `angle` [rad]: its centre at its lower end."""
    p = vector(np.array(top) + pendulum_end(1.0, angle))
    return free(name, mass=mass, moments=(moment,) * 3, p=p, q=axis_angle(Y, angle))


def _slide(body: Body, axis: Vector3 = (1.0, 0.0, 0.0), **laws: Any) -> Prismatic:
    return prismatic(f"slide {body.name}", body.name, ORIGIN, axis, **laws)


@check(
    "Does a rotor add its inertia to a joint's coordinate, and no weight?",
    Feature.REVOLUTE | Feature.PRISMATIC | Feature.ARMATURE,
)
def armature_adds_inertia(engine: Engine) -> Comparisons:
    """(I + m l^2 + A) a'' = -m g l sin a of a pendulum, and (m + A) x'' = m g of a slide, whose rotor has no weight."""
    t, rotor = 1.0, 3.0
    angle, rate = swing(2.0 * G, 2.2 + rotor, t)
    pin = revolute("pin", "bob", ORIGIN, Y, armature=rotor)
    carriage = free("carriage", p=(0.0, 5.0, 0.0))
    scene = Scene(bodies=(_hanging("bob", 1.0), carriage), joints=(pin, _slide(carriage, (0.0, 0.0, -1.0), armature=rotor)))
    end = engine.final(scene, t)
    fallen = 0.5 * 2.0 * G / (2.0 + rotor) * t * t
    yield near("bob after 1 s [m]", end.p_WB[0], pendulum_end(1.0, angle), _HALF_A_STEP, "half a step of motion")
    yield near("its angular velocity [rad/s]", end.w_WB[0], (0.0, rate, 0.0), 0.02, "a step of its acceleration")
    yield near("a slide with a rotor of 3 kg falls [m]", -end.p_WB[1, 2], fallen, _HALF_A_STEP, "half a step of motion")


@check(
    "Does a rotor between two moving bodies turn with the angle between them, and react on both?",
    Feature.REVOLUTE | Feature.ARMATURE,
)
def armature_acts_between_bodies(engine: Engine) -> Comparisons:
    """Two rods on each other, a rotor at the elbow alone: it turns with the angle between them, and reacts on both.

    With absolute angles a, b, m = 2 kg, l = 1 m, I = .2 kg m2 and rotor A:
    (2 m l^2 + I + A) a'' + (m l^2 cos(a-b) - A) b'' = -m l^2 sin(a-b) b'^2 - 2 m g l sin a, and likewise for b.
    """
    t, rotor, m, moment = 0.6, 1.5, 2.0, 0.2

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        a, b, u, v = y
        M = np.array([[2 * m + moment + rotor, m * cos(a - b) - rotor], [m * cos(a - b) - rotor, m + moment + rotor]])
        force = np.array([-m * sin(a - b) * v * v - 2 * m * G * sin(a), m * sin(a - b) * u * u - m * G * sin(b)])
        return np.concatenate(((u, v), np.linalg.solve(M, force)))

    a, b, u, v = solve_ivp(rates, (0, t), (1.0, -0.5, 0.0, 0.0), rtol=1e-10, atol=1e-10).y[:, -1]
    upper = _hanging("upper", 1.0)
    lower = _hanging("lower", -0.5, upper.p_WB)
    joints = (
        revolute("shoulder", "upper", ORIGIN, Y),
        revolute("elbow", "lower", upper.p_WB, Y, armature=rotor, parent="upper"),
    )
    end = engine.final(Scene(bodies=(upper, lower), joints=joints), t)
    elbow = np.array(pendulum_end(1.0, a))
    because = "half a step of motion, and default damping"
    yield near("end of the upper rod [m]", end.p_WB[0], elbow, _HALF_A_STEP, because)
    yield near("end of the lower rod [m]", end.p_WB[1], elbow + pendulum_end(1.0, b), 2 * _HALF_A_STEP, because)
    yield near("angular velocities [rad/s]", end.w_WB[:, 1], (u, v), 0.03, "a step of their accelerations")


@check(
    "Does dry friction in a joint take as much from any speed?", Feature.REVOLUTE | Feature.PRISMATIC | Feature.FRICTION_LOSS
)
def dry_friction_brakes(engine: Engine) -> Comparisons:
    """m x'' = -f: 2 kg at 2 m/s stop under 3 N after m v^2 / 2 f; a hinge at -2 rad/s after I w^2 / 2 f."""
    carriage = free("carriage", v=(2.0, 0.0, 0.0))
    wheel = free("wheel", p=(0.0, 5.0, 0.0), moments=(0.3, 0.3, 0.3), w=(0.0, 0.0, -2.0))
    pin = revolute("pin", "wheel", (0.0, 5.0, 0.0), Z, friction_loss=0.5)
    scene = without_gravity(carriage, wheel, joints=(_slide(carriage, friction_loss=3.0), pin))
    end = engine.final(scene, 1.8)
    yield near("way to the stop [m]", end.p_WB[0, 0], 2.0 * 4.0 / 6.0, _HALF_A_STEP, "v dt/2")
    yield aligned("turn to the stop [rad]", end.q_WB[1], axis_angle(Z, -1.2), _HALF_A_STEP, "w dt/2")
    rates, because = (end.v_WB[0, 0], end.w_WB[1, 2]), "nothing moves them; soft friction creeps"
    yield near("velocities there", rates, (0.0, 0.0), 2e-3, because)


@check("Does dry friction hold a joint up to its bound, and let it go above?", Feature.PRISMATIC | Feature.FRICTION_LOSS)
def dry_friction_holds(engine: Engine) -> Comparisons:
    """Under .9 of its bound a slide stays; under 1.1 of it, it is pulled by the tenth that is left."""
    t, loss, pull = 1.0, 4.0, 2.0
    stuck, loose = free("stuck", mass=0.9 * loss / pull), free("loose", mass=1.1 * loss / pull, p=(0.0, 5.0, 0.0))
    joints = tuple(_slide(body, friction_loss=loss) for body in (stuck, loose))
    end = engine.final(Scene(bodies=(stuck, loose), joints=joints, gravity=(pull, 0.0, 0.0)), t)
    way = 0.5 * 0.1 * loss / (1.1 * loss / pull) * t * t
    yield near("way under .9 of the bound [m]", end.p_WB[0, 0], 0.0, _HALF_A_STEP, "it holds; soft friction creeps by mm/s")
    because = "half a step, and what soft friction creeps"
    yield near("way under 1.1 of the bound [m]", end.p_WB[1, 0], way, _HALF_A_STEP, because)


@check(
    "Do a drive and dry friction in one joint both keep their laws?", Feature.PRISMATIC | Feature.FRICTION_LOSS | Feature.DRIVES
)
def dry_friction_beside_a_drive(engine: Engine) -> Comparisons:
    """Drives of 100 N/m at a bound of 3 N: a push of 2 N moves nothing; one of 10 N moves, and stops within 3 N of its target.

    A drive c = 60 N s/m slow enough creeps on until its pull is f: at t -> oo, x = target - f/k, from below.
    """
    near_by, far = free("near"), free("far", p=(0.0, 5.0, 0.0))
    drives = (Drive(stiffness=100.0, damping=60.0, target=0.02), Drive(stiffness=100.0, damping=60.0, target=0.1, limit=50.0))
    joints = tuple(_slide(b, friction_loss=3.0, drive=d) for b, d in zip((near_by, far), drives, strict=True))
    end = engine.final(without_gravity(near_by, far, joints=joints), 8.0)
    yield near("way under a push of 2 N [m]", end.p_WB[0, 0], 0.0, _HALF_A_STEP, "below the bound; soft friction creeps")
    yield near("way under one of 10 N [m]", end.p_WB[1, 0], 0.1 - 3.0 / 100.0, _HALF_A_STEP, "until the pull is 3 N")


@check(
    "Does a joint under a constant force reach its speed limit as without one, and stay at it?",
    Feature.REVOLUTE | Feature.PRISMATIC | Feature.SPEED_LIMIT | Feature.DRIVES | Feature.FEEDFORWARD,
)
def speed_limit_is_reached_and_kept(engine: Engine) -> Comparisons:
    """A slide of 2 kg under 4 N and a hinge of .3 kg m2 under -.6 N m: x' = a t up to the limit s, then x = s t - s^2 / 2 a.

    A third slide starts above its limit, at 2 m/s: an impulse brings it to it at once.
    """
    t, limit = 1.2, 1.5
    carriage, wheel = free("carriage"), free("wheel", p=(0.0, 5.0, 0.0))
    pin = revolute("pin", "wheel", wheel.p_WB, Y, speed_limit=limit, drive=Drive(feedforward=-0.6))
    fast = free("fast", p=(0.0, 9.0, 0.0), v=(-2.0, 0.0, 0.0))
    joints = (_slide(carriage, speed_limit=limit, drive=Drive(feedforward=4.0)), pin, _slide(fast, speed_limit=limit))
    end = engine.final(without_gravity(carriage, wheel, fast, joints=joints), t)
    way = limit * t - limit**2 / (2 * 2.0)
    turned = axis_angle(Y, -way)
    yield near("speed of a pushed slide [m/s]", end.v_WB[0, 0], limit, 2e-3, "rounding, and default damping")
    yield near("its way [m]", end.p_WB[0, 0], way, _HALF_A_STEP, "half a step of motion")
    yield near("rate of a driven hinge [rad/s]", end.w_WB[1, 1], -limit, 2e-3, "rounding, and default damping")
    yield aligned("its turn [rad]", end.q_WB[1], turned, _HALF_A_STEP, "half a step of motion")
    yield near("way of a slide that was too fast [m]", end.p_WB[2, 0], -limit * t, _HALF_A_STEP, "a step of what was too fast")


@check(
    "Is what keeps a joint at its speed limit a force between its two bodies?",
    Feature.PRISMATIC | Feature.SPEED_LIMIT | Feature.DRIVES | Feature.FEEDFORWARD,
)
def speed_limit_reacts_on_both_bodies(engine: Engine) -> Comparisons:
    """2 and 3 kg on one slide, pushed apart by 6 N in space: their momenta cancel, their speeds part by the limit s.

    What holds the rate is a force between the two: the motor's reaction on the first is that of the second. A rate that is
    cut off in the second body alone would leave momentum from nowhere, 1.2 kg m/s a second.
    """
    limit, t = 1.5, 1.2
    first, second = free("first", mass=2.0), free("second", mass=3.0, p=(0.5, 0.0, 0.0))
    rail = prismatic(
        "rail", "second", second.p_WB, (1.0, 0.0, 0.0), speed_limit=limit, drive=Drive(feedforward=6.0), parent="first"
    )
    end = engine.final(without_gravity(first, second, joints=(rail,)), t)
    because = "m_1 v_1 + m_2 v_2 = 0, v_2 - v_1 = s; default damping"
    yield near("velocities along the rail [m/s]", end.v_WB[:, 0], (-0.6 * limit, 0.4 * limit), 2e-3, because)


@check(
    "Are two coordinates tied by ratio and offset, and does each feel the other's inertia?",
    Feature.REVOLUTE | Feature.PRISMATIC | Feature.COUPLING,
)
def coupled_coordinates_move_as_one(engine: Engine) -> Comparisons:
    """x = r y + b: a pendulum that drives a wheel, (I + m l^2 + J/r^2) a'' = -m g l sin a; a weight on a drum, (m + J/r^2)."""
    t, ratio, wheel_moment = 0.8, -2.0, 4.0
    angle, rate = swing(2.0 * G, 2.2 + wheel_moment / ratio**2, t)
    drum_ratio, drum_moment = 0.5, 0.3
    wheel = free("wheel", p=(0.0, 3.0, 0.0), moments=(wheel_moment,) * 3)
    drum, weight = free("drum", p=(0.0, 6.0, 0.0)), free("weight", p=(0.0, 9.0, 0.0))
    joints = (
        revolute(
            "pin", "bob", ORIGIN, Y, position=1.0,
            coupling=Coupling(joint="axle", ratio=ratio, offset=1.4),
        ),
        revolute("axle", "wheel", wheel.p_WB, Y, position=0.2),
        revolute("drum", "drum", drum.p_WB, X),
        _slide(weight, (0.0, 0.0, -1.0), coupling=Coupling(joint="drum", ratio=drum_ratio)),
    )  # fmt: skip
    scene = Scene(bodies=(_hanging("bob", 1.0), wheel, drum, weight), joints=joints)
    run = engine.record(scene, t, every=20)
    fallen = 0.5 * 2.0 * G / (2.0 + drum_moment / drum_ratio**2) * t * t
    turned = axis_angle(Y, (float(angle) - 1.0) / ratio)
    yield near("bob [m]", run.p_WB[-1, 0], pendulum_end(1.0, angle), _HALF_A_STEP, "half a step of motion")
    yield aligned(
        "wheel, against the bob's turn over r [rad]", run.q_WB[-1, 1], turned, _HALF_A_STEP, "the tie, and half a step"
    )
    yield near("rates of both [rad/s]", run.w_WB[-1, :2, 1], (rate, rate / ratio), 0.02, "a step of their accelerations")
    yield near("weight on a drum falls [m]", -run.p_WB[-1, 3, 2], fallen, _HALF_A_STEP, "half a step of motion")
    apart = -run.v_WB[:, 3, 2] - drum_ratio * run.w_WB[:, 2, 0]
    because = "the tie; one that is soft gives way by a step of its acceleration"
    yield near("rate of the weight over that of the drum, at all times [m/s]", apart, np.zeros(len(run.time)), 0.02, because)
