"""A converged reference: one engine at a ladder of time steps, extrapolated to a step of zero, with an error bar of its own.

Four runs f_1 .. f_4 about halve the step each time. With a first-order method f_i = f + c h_i + ..., so that the extrapolants

    R_i = (h_i f_{i+1} - h_{i+1} f_i) / (h_i - h_{i+1})

lose the first term, and what is left of their differences tells how well. Where these are at most a quarter of the differences
of the runs themselves, the truth is R_3 and its bar

    1.25 max(|R_3 - R_2|, |R_2 - R_1| (h_3 / h_2)^2),

the second brought to the step of the first. Both are asked for because the end of a slip within a step leaves an error of order
h^2 whose size depends on where within the step it falls, and one difference may be small by chance. Elsewhere, as after an
impact, nothing may be extrapolated: the truth is f_4 and its bar 3 max_i |f_{i+1} - f_i| h_4 / h_{i+1}, the error of a
first-order method seen from each difference, three times over. Round-off of all steps is added.

Steps that divide each other have instants in common. The end of a slip a little before one of these looks alike to all runs,
and its error, half the jump of the acceleration times the square of the distance in time, hides from every difference. The
numbers of steps between two samples are therefore relatively prime, and since samples remain in common, half the largest jump
of the mean acceleration times h_4^2 is added to the bar of positions.

Source: Richardson, Phil. Trans. R. Soc. A 210, 1911; Roache, J. Fluids Eng. 116, 1994 (grid convergence index: safety 1.25
where the order is observed, 3 where it is not).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from harness.adapter import Adapter, Settings
from harness.case import Converged
from harness.metric import NotMeasurable
from harness.scene import Scene
from harness.trajectory import Floats, State, Trajectory

__all__ = ["Extrapolation", "converged", "extrapolate", "ladder"]

OBSERVED, UNSEEN = 1.25, 3.0
"""Roache's factors of safety with and without an observed order."""
FIRST_ORDER = 0.25
"""Largest difference of extrapolants, relative to that of runs, that counts as first order."""

CERTIFIED = 1e-10
"""Largest relative residual of a step that a truth may rest on."""


@dataclass(frozen=True, slots=True)
class Extrapolation:
    """A value at a step of zero, its error bar in the same unit, and the order that the finer runs show (nan: none)."""

    value: Floats
    error: float
    order: float


def ladder(fewest: int) -> tuple[int, int, int, int]:
    """Steps from sample to sample in the four runs: at least `fewest`, each about twice the last, without common factors."""
    while np.gcd(fewest, 15) > 1:
        fewest += 1
    return fewest, 2 * fewest + 1, 4 * fewest + 3, 8 * fewest + 5


def extrapolate(runs: Sequence[Floats], counts: Sequence[int], round_off: float) -> Extrapolation:
    """From four runs (t, ...).

    Args: counts: steps of each run from sample to sample; round_off: what the arithmetic of the finest run may have cost, in
        the unit of the values.
    """
    n = np.array(counts, float)
    made = [(n[i + 1] * runs[i + 1] - n[i] * runs[i]) / (n[i + 1] - n[i]) for i in range(3)]
    moved = [float(np.abs(finer - coarser).max(initial=0.0)) for coarser, finer in pairwise(runs)]
    left = [float(np.abs(finer - coarser).max(initial=0.0)) for coarser, finer in pairwise(made)]
    order = _order(moved[1] / moved[2], n[1:]) if min(moved[1:]) > round_off else float("nan")
    # An extrapolant multiplies the round-off of its runs by about three.
    if all(rest <= FIRST_ORDER * size + 6.0 * round_off for rest, size in zip(left, moved, strict=False)):
        return Extrapolation(made[2], OBSERVED * max(left[1], left[0] * (n[1] / n[2]) ** 2) + 3.0 * round_off, order)
    error = UNSEEN * max(size * n[i + 1] / n[3] for i, size in enumerate(moved))
    return Extrapolation(runs[3], error + round_off, order)


def _order(ratio: float, n: Floats) -> float:
    """The p at which (h_2^p - h_3^p) / (h_3^p - h_4^p), which grows with p, is the ratio seen; within 0.1..8."""
    p = np.linspace(0.1, 8.0, 791)
    return float(np.interp(ratio, (n[0] ** -p - n[1] ** -p) / (n[1] ** -p - n[2] ** -p), p))


def converged(scene: Scene, time: Floats, adapter: Adapter, coarsest: float) -> Converged:
    """The truth of a scene without a closed form, by the exact solver of the reference engine.

    Args: time (t,) s: evenly spaced samples from 0; adapter: the reference; coarsest [s]: no run takes longer steps.
    Raises: NotMeasurable for times that are not evenly spaced, and where the solver's certificate fails; what the adapter
        raises for scenes it cannot express.
    """
    spacing = float(time[1] - time[0]) if len(time) > 1 else coarsest
    if not np.allclose(time, spacing * np.arange(len(time)), rtol=0.0, atol=1e-9):
        raise NotMeasurable("the samples are not evenly spaced from 0")
    counts = ladder(max(1, int(np.ceil(spacing / coarsest - 1e-9))))
    runs = [_run(scene, time, adapter, spacing, count) for count in counts]
    finest = runs[-1]
    p_WB, v_WB = (
        # Every step rounds a sum of the size of the values once.
        extrapolate([getattr(run, name) for run in runs], counts, counts[-1] * len(time) * 2.0**-53 * _size(finest, name))
        for name in ("p_WB", "v_WB")
    )
    jump = float(np.abs(np.diff(finest.v_WB, n=2, axis=0)).max(initial=0.0)) / spacing
    # Bars are of components; a length may be off by the root of three times as much.
    return Converged(
        trajectory=replace(finest, p_WB=p_WB.value, v_WB=v_WB.value, dt=0.0),
        position_error=3.0**0.5 * (p_WB.error + 0.5 * jump * (spacing / counts[-1]) ** 2),
        velocity_error=3.0**0.5 * v_WB.error,
    )


def _size(trajectory: Trajectory, name: str) -> float:
    """The largest value, at least one of its unit."""
    return float(np.abs(getattr(trajectory, name)).max(initial=1.0))


def _run(scene: Scene, time: Floats, adapter: Adapter, spacing: float, every: int) -> Trajectory:
    """One run with `every` steps from sample to sample."""
    simulation = adapter.build(scene, Settings(dt=spacing / every, solver="exact"))
    try:
        trajectory = Trajectory.of(time, len(scene.bodies))
        for k in range(len(time)):
            if k > 0:
                simulation.step(every)
            state: State = trajectory.state(k)
            simulation.state(state)
        residual = float(simulation.resolved.options.get("residual", 0.0))
        if residual > CERTIFIED:
            raise NotMeasurable(f"a step of the reference has a residual of {residual:.1g}, expected at most {CERTIFIED:g}")
    finally:
        simulation.close()
    return trajectory
