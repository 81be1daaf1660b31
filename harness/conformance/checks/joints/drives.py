"""Checks of drives: the target velocity acts, and a command reaches every drive that it names and no other."""

from math import exp

from harness.adapter import Adapter, Feature, Settings
from harness.conformance.check import ConformanceCheck, Finding, judge, near
from harness.conformance.runs import FINE, built, final, state_of
from harness.conformance.scenes import free
from harness.scene import WORLD, Drive, Prismatic, Scene

__all__ = ["CHECKS"]


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


def _target_velocity_acts(adapter: Adapter, settings: Settings) -> Finding:
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


def _command_reaches_every_drive(adapter: Adapter, settings: Settings) -> Finding:
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


CHECKS = (
    ConformanceCheck(
        name="target_velocity_acts",
        question="Does a drive's target velocity act, alone and beside its target?",
        run=_target_velocity_acts,
        needs=Feature.PRISMATIC | Feature.DRIVES,
    ),
    ConformanceCheck(
        name="command_reaches_every_drive",
        question="Does a command reach every drive that it names, and no other?",
        run=_command_reaches_every_drive,
        needs=Feature.PRISMATIC | Feature.DRIVES,
        excusable=False,
    ),
)
