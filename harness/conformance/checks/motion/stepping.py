"""Checks of single steps: none is taken when none is asked for, and each is as long as the others."""

import numpy as np

from harness.adapter import Adapter, Feature, Settings
from harness.conformance.check import Finding, check, judge, near
from harness.conformance.runs import COARSE, ROUNDING, built, record, state_of
from harness.conformance.scenes import TURNED, G, free
from harness.scene import Scene


def _falling() -> Scene:
    """One body falls, another flies on and turns."""
    return Scene(bodies=(free(), free("other", p=(5.0, 0.0, 0.0), q=TURNED, v=(3.0, 0.0, 0.0), w=(1.0, 2.0, -1.0))))


@check("Does step(0) leave the state as it is, bit for bit?", firm=True)
def no_step_is_no_step(adapter: Adapter, settings: Settings) -> Finding:
    comparisons, scene = [], _falling()
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        for when in ("right after build", "after 5 steps"):
            before = state_of(simulation, scene)
            simulation.step(0)
            after = state_of(simulation, scene)
            for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
                what = f"change of {name} by step(0) {when}"
                comparisons.append(
                    near(what, getattr(after, name) - getattr(before, name), np.zeros_like(getattr(after, name)), 0.0)
                )
            simulation.step(5)
    return judge(*comparisons)


@check("Is every single step dt long, not only the mean of many?", firm=True)
def steps_are_even(adapter: Adapter, settings: Settings) -> Finding:
    """Each step adds g dt to the speed of what falls and v dt to the way of what flies, not only all of them together."""
    run = record(adapter, _falling(), settings.with_dt(COARSE), 8 * COARSE)
    dv, dx = np.diff(run.v_WB[:, 0, 2]), np.diff(run.p_WB[:, 1, 0])
    because = "1 %: default damping, judged elsewhere, takes .1 %; steps of .9 and 1.1 dt are 10 % off"
    return judge(
        near("speed gained in each of 8 steps [m/s]", dv, np.full(8, -G * COARSE), 0.01 * G * COARSE, because),
        near("way gained in each of 8 steps [m]", dx, np.full(8, 3.0 * COARSE), 0.01 * 3.0 * COARSE, because),
    )


LENGTHS = (1.0, 0.5, 2.0, 1.25, 0.75, 0.5)
"""Of steps, in dt: each may be shorter or longer than the one before; their mean is 1."""


@check("Is every step as long as was told for it, where lengths are uneven?", Feature.STEP_LENGTHS, firm=True)
def step_lengths_are_kept(adapter: Adapter, settings: Settings) -> Finding:
    """Step h adds g h to the speed of what falls and v h to the way of what flies, and the fall is the sum of all of them.

    Semi-implicit Euler falls by g sum(h_k (h_1 + .. + h_k)), g sum(h_k^2)/2 more than g t^2/2; explicit Euler by as much less,
    and what is more exact, or takes sub-steps, lies between the two.
    """
    lengths = COARSE * np.array(LENGTHS)
    states, scene = [], _falling()
    with built(adapter, scene, settings.with_dt(COARSE)) as simulation:
        states.append(state_of(simulation, scene))
        for length in lengths.tolist():
            simulation.retime(length)  # type: ignore[attr-defined]  # what an engine may offer, see harness.adapter
            simulation.step()
            states.append(state_of(simulation, scene))
    v, x = np.array([state.v_WB[0, 2] for state in states]), np.array([state.p_WB[1, 0] for state in states])
    t, fallen = float(lengths.sum()), states[0].p_WB[0, 2] - states[-1].p_WB[0, 2]
    because = "1 % of dt: a default damping of .16 1/s takes half of it; a length that is ignored is 25 % of dt off or more"
    staggered = 1.01 * G * float((lengths**2).sum()) / 2 + ROUNDING
    return judge(
        near("speed gained in each of 6 steps [m/s]", np.diff(v), -G * lengths, 0.01 * G * COARSE, because),
        near("way gained in each of 6 steps [m]", np.diff(x), 3.0 * lengths, 0.01 * 3.0 * COARSE, because),
        near("way fallen [m]", fallen, G * t * t / 2, staggered, "g sum(h^2)/2 of a scheme of first order"),
    )
