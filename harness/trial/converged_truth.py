"""A converged reference: one engine at a ladder of time steps, extrapolated to a step of zero, with an error bar of its own.

Four runs about halve the step each time; their limit and its bar are Richardson's, of a first-order method
(`harness.statistics.richardson`).

Steps that divide each other have instants in common. The end of a slip a little before one of these looks alike to all runs,
and its error, half the jump of the acceleration times the square of the distance in time, hides from every difference. The
numbers of steps between two samples are therefore relatively prime, and since samples remain in common, half the largest jump
of the mean acceleration times h_4^2 is added to the bar of positions.
"""

from dataclasses import replace

import numpy as np

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.case import Converged
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.scene import Scene
from plumbline.harness.statistics.richardson import extrapolate
from plumbline.harness.trajectory import Floats, State, Trajectory

CERTIFIED = 1e-10
"""Largest relative residual of a step that a truth may rest on."""
PATIENCE = 1e6
"""Effort [ms] that a solve of the reference may take: all methods to their ends."""


def ladder(fewest: int) -> tuple[int, int, int, int]:
    """Steps from sample to sample in the four runs: at least `fewest`, each about twice the last, without common factors."""
    while np.gcd(fewest, 15) > 1:
        fewest += 1
    return fewest, 2 * fewest + 1, 4 * fewest + 3, 8 * fewest + 5


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
    simulation = adapter.build(scene, Settings(dt=spacing / every, solver="exact", options={"effort": PATIENCE}))
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
