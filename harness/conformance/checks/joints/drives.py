"""Checks of drives: target velocity and feedforward act, and a command reaches every drive that it names and no other."""

from math import exp

from harness.adapter import Adapter, Feature, Settings
from harness.conformance.check import Finding, check, judge, near
from harness.conformance.runs import FINE, built, final, state_of
from harness.conformance.scenes import TURNED, free
from harness.scene import WORLD, Drive, Prismatic, Revolute, Scene


def _driven(*drives: Drive) -> Scene:
    """Bodies of 2 kg beside each other, each on a slide along x with its drive, without gravity."""
    return Scene(
        bodies=tuple(free(f"body{k}", p=(0.0, 3.0 * k, 0.0)) for k in range(len(drives))),
        joints=tuple(
            Prismatic(
                name=f"slide{k}",
                parent=WORLD,
                child=f"body{k}",
                anchor_W=(0.0, 3.0 * k, 0.0),
                axis_W=(1.0, 0.0, 0.0),
                drive=drive,
            )
            for k, drive in enumerate(drives)
        ),
        gravity=(0.0, 0.0, 0.0),
    )


@check("Does a drive's target velocity act, alone and beside its target?", Feature.PRISMATIC | Feature.DRIVES)
def target_velocity_acts(adapter: Adapter, settings: Settings) -> Finding:
    """Without stiffness v = u (1 - e^(-c t/m)); with stiffness k as well, the body rests at target + c u/k."""
    c, u, t, m = 8.0, 0.5, 0.3, 2.0
    rest = Drive(stiffness=200.0, damping=60.0, target=0.1, target_velocity=u)
    scene = _driven(Drive(damping=c, target_velocity=u), rest)
    early, late = (final(adapter, scene, settings.with_dt(FINE), time) for time in (t, 3.0))
    expected = u * (1 - exp(-c * t / m))
    return judge(
        near("speed under c (u - v) after .3 s [m/s]", early.v_WB[0, 0], expected, 5e-3, "c u/m dt, and default damping"),
        near("place at rest under k (x0 - x) + c u [m]", late.p_WB[1, 0], 0.1 + 60.0 * u / 200.0, 2e-3, "both terms balance"),
    )


@check("Does a command reach every drive that it names, and no other?", Feature.PRISMATIC | Feature.DRIVES, firm=True)
def command_reaches_every_drive(adapter: Adapter, settings: Settings) -> Finding:
    """Three drives at 0; the last two are sent off, then the first alone."""
    scene = _driven(*(Drive(stiffness=200.0, damping=40.0) for _ in range(3)))
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        simulation.command({"slide2": 0.3, "slide1": -0.2})
        simulation.step(1500)
        first = state_of(simulation, scene).p_WB[:, 0]
        simulation.command({"slide0": 0.1})
        simulation.step(1500)
        second = state_of(simulation, scene).p_WB[:, 0]
    return judge(
        near("places after a command to the last two [m]", first, (0.0, -0.2, 0.3), 2e-3, "e^(-10 t) has died out"),
        near("places after a command to the first [m]", second, (0.1, -0.2, 0.3), 2e-3, "the others keep their targets"),
    )


@check(
    "Does a constant force in a drive's law act, alone, beside the PD law and within the limit?",
    Feature.PRISMATIC | Feature.DRIVES | Feature.FEEDFORWARD,
)
def feedforward_acts(adapter: Adapter, settings: Settings) -> Finding:
    """Motors of 1.5 N, one of them cut off at 1 N; one beside a damper; one beside a PD law, before and after a command."""
    t, m, c = 0.3, 2.0, 8.0
    scene = _driven(
        Drive(feedforward=1.5),
        Drive(feedforward=-1.5, limit=1.0),
        Drive(damping=c, target_velocity=0.2, feedforward=1.5),
        Drive(stiffness=200.0, damping=40.0, target=0.1, feedforward=6.0),
    )
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        simulation.step(300)
        early = state_of(simulation, scene).v_WB[:3, 0]
        simulation.step(1200)
        first = float(state_of(simulation, scene).p_WB[3, 0])
        simulation.command({"slide3": -0.1})
        simulation.step(1500)
        second = float(state_of(simulation, scene).p_WB[3, 0])
    speeds = (1.5 * t / m, -1.0 * t / m, (0.2 + 1.5 / c) * (1 - exp(-c * t / m)))
    return judge(
        near("speeds after .3 s under a motor, a limited one and a damped one [m/s]", early, speeds, 5e-3, "f t/m, 2 %"),
        near("place at rest under k (x0 - x) + b [m]", first, 0.1 + 6.0 / 200.0, 2e-3, "e^(-10 t) has died out"),
        near("place after the command to -.1 [m]", second, -0.1 + 6.0 / 200.0, 2e-3, "a command leaves the push as it is"),
    )


@check(
    "Does a motor between two bodies turn both, about the joint's axis and against each other?",
    Feature.REVOLUTE | Feature.DRIVES | Feature.FEEDFORWARD,
)
def motor_turns_two_bodies(adapter: Adapter, settings: Settings) -> Finding:
    """A motor between two wheels about a slanted axis: opposite turns about that axis, each of tau t/I; the hub rests."""
    axis, tau, t = (2.0 / 3, -1.0 / 3, 2.0 / 3), 0.6, 0.3
    bodies = (free("stator", moments=(0.6, 0.6, 0.6)), free("rotor", moments=(0.3, 0.3, 0.3), q=TURNED))
    hub = Revolute(
        name="hub", parent="stator", child="rotor", anchor_W=(0.0, 0.0, 0.0), axis_W=axis, drive=Drive(feedforward=tau)
    )
    end = final(adapter, Scene(bodies=bodies, joints=(hub,), gravity=(0.0, 0.0, 0.0)), settings.with_dt(FINE), t)
    expected = [[-tau * t / 0.6 * c for c in axis], [tau * t / 0.3 * c for c in axis]]
    return judge(
        near("angular velocities [rad/s]", end.w_WB, expected, 0.02, "tau t/I and no more; 3 % for default damping"),
        near("places of both [m]", end.p_WB, [[0.0] * 3] * 2, 1e-6, "a couple moves no centre of mass"),
    )
