"""Checks of what a save holds: wrench and targets are part of what decides the future."""

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation
from harness.conformance.check import Finding, check, judge, near
from harness.conformance.runs import COARSE, FINE, built, state_of
from harness.conformance.scenes import free, without_gravity
from harness.scene import WORLD, Drive, Prismatic, Scene
from harness.trajectory import Floats


def _after(simulation: Simulation, scene: Scene, steps: int = 20) -> Floats:
    simulation.step(steps)
    return state_of(simulation, scene).p_WB


@check("Does restore bring back the forces that were told when it was saved, and no others?", Feature.SAVE | Feature.WRENCH)
def restore_brings_back_the_wrench(adapter: Adapter, settings: Settings) -> Finding:
    """A push told after a save is forgotten with it; one told before it acts again."""
    scene = without_gravity(free(), free("other", p=(5.0, 0.0, 0.0)))
    push, none = np.zeros((2, 3)), np.zeros((2, 3))
    push[0, 0] = 10.0
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        simulation.step(5)
        quiet = simulation.save()
        unpushed = _after(simulation, scene)
        simulation.wrench(push, none)
        pushed_from = simulation.save()
        pushed = _after(simulation, scene)
        simulation.restore(quiet)
        first = _after(simulation, scene)
        simulation.wrench(none, none)
        simulation.restore(pushed_from)
        second = _after(simulation, scene)
    return judge(
        near("p_WB after restoring what nobody pushed [m]", first, unpushed, 0.0, "the same bits"),
        near("p_WB after restoring what was pushed [m]", second, pushed, 0.0, "the same bits"),
        near("way of what was pushed [m]", pushed[0, 0], 5.0 / 2 * (20 * COARSE) ** 2, 2e-3, "F t^2/2m, and half a step"),
    )


@check("Does restore bring back the targets of the drives?", Feature.SAVE | Feature.PRISMATIC | Feature.DRIVES)
def restore_brings_back_the_targets(adapter: Adapter, settings: Settings) -> Finding:
    drive = Drive(stiffness=50.0, damping=20.0)
    slide = Prismatic(name="slide", parent=WORLD, child="body", anchor_W=(0.0, 0.0, 0.0), axis_W=(1.0, 0.0, 0.0), drive=drive)
    scene = Scene(bodies=(free(),), joints=(slide,), gravity=(0.0, 0.0, 0.0))
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        simulation.command({"slide": 0.1})
        simulation.step(50)
        saved = simulation.save()
        expected = _after(simulation, scene, 200)
        simulation.command({"slide": -0.4})
        simulation.step(10)
        simulation.restore(saved)
        got = _after(simulation, scene, 200)
    return judge(near("p_WB on the way to the target of the save [m]", got, expected, 0.0, "the same bits"))
