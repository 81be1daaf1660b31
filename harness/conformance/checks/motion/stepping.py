"""Checks of single steps: none is taken when none is asked for, and each is as long as the others."""

import numpy as np

from harness.adapter import Adapter, Settings
from harness.conformance.check import ConformanceCheck, Finding, judge, near
from harness.conformance.runs import COARSE, built, record, state_of
from harness.conformance.scenes import TURNED, G, free
from harness.scene import Scene

__all__ = ["CHECKS"]


def _falling() -> Scene:
    """One body falls, another flies on and turns."""
    return Scene(bodies=(free(), free("other", p=(5.0, 0.0, 0.0), q=TURNED, v=(3.0, 0.0, 0.0), w=(1.0, 2.0, -1.0))))


def _no_step_is_no_step(adapter: Adapter, settings: Settings) -> Finding:
    found, scene = [], _falling()
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        for when in ("right after build", "after 5 steps"):
            before = state_of(simulation, scene)
            simulation.step(0)
            after = state_of(simulation, scene)
            for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
                what = f"change of {name} by step(0) {when}"
                found.append(near(what, getattr(after, name) - getattr(before, name), np.zeros_like(getattr(after, name)), 0.0))
            simulation.step(5)
    return judge(*found)


def _steps_are_even(adapter: Adapter, settings: Settings) -> Finding:
    """Each step adds g dt to the speed of what falls and v dt to the way of what flies, not only all of them together."""
    run = record(adapter, _falling(), settings.with_dt(COARSE), 8 * COARSE)
    dv, dx = np.diff(run.v_WB[:, 0, 2]), np.diff(run.p_WB[:, 1, 0])
    because = "1 %: default damping, judged elsewhere, takes .1 %; steps of .9 and 1.1 dt are 10 % off"
    return judge(
        near("speed gained in each of 8 steps [m/s]", dv, np.full(8, -G * COARSE), 0.01 * G * COARSE, because),
        near("way gained in each of 8 steps [m]", dx, np.full(8, 3.0 * COARSE), 0.01 * 3.0 * COARSE, because),
    )


CHECKS = (
    ConformanceCheck(
        name="no_step_is_no_step",
        question="Does step(0) leave the state as it is, bit for bit?",
        run=_no_step_is_no_step,
        excusable=False,
    ),
    ConformanceCheck(
        name="steps_are_even",
        question="Is every single step dt long, not only the mean of many?",
        run=_steps_are_even,
        excusable=False,
    ),
)
