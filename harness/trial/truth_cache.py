"""What a trial is measured by: the truth, of the case or made by the reference engine, and bounds; what takes long is kept.

A converged reference: one engine at a ladder of time steps, extrapolated to a step of zero, with an error bar of its own.

Four runs about halve the step each time; their limit and its bar are Richardson's, of a first-order method
(`harness.statistics.richardson`).

Steps that divide each other have instants in common. The end of a slip a little before one of these looks alike to all runs,
and its error, half the jump of the acceleration times the square of the distance in time, hides from every difference. The
numbers of steps between two samples are therefore relatively prime, and since samples remain in common, half the largest jump
of the mean acceleration times h_4^2 is added to the bar of positions.
"""

import sys
import time as clock
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.case import Case, Converged
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.scene import Scene
from plumbline.harness.scene.file import dump_json
from plumbline.harness.statistics.richardson import extrapolate
from plumbline.harness.store.arrays import read_arrays, write_arrays
from plumbline.harness.store.record import digest
from plumbline.harness.store.seal import Damaged
from plumbline.harness.study.plugins import adapter
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


LONG = 0.1
"""Seconds from which on a closed form or a bound is kept: reading it back takes a few milliseconds."""


def truth_of(
    case: Case,
    scene: Scene,
    time: Floats,
    parameters: Mapping[str, Any],
    folder: Path | None,
    sources: Mapping[str, str] | None = None,
) -> Converged | None:
    """What the answer at the times (t,) s is measured by: a closed form has errors of zero.

    A truth that takes long to make is kept under `folder`, named by all that it depends on; one that was damaged is made again.

    Args: sources: of the trial that is measured.
    Raises: NotMeasurable, Unsupported: the reference cannot make it.
    """
    laws = _laws(sources)
    if case.coarsest is not None:
        reference = adapter("reference")
        asked = {"scene": dump_json(scene), "time": time.tolist(), "step": case.coarsest, "engine": reference.version()}
        kept = _place(folder, asked | {"laws": laws})
        if (arrays := _read(kept)) is not None:
            return _truth(arrays)
        made = converged(scene, time, reference, case.coarsest)
        _keep_truth(kept, made)
        return made
    kept = _place(folder, {"case": case.name, "parameters": dict(parameters), "time": time.tolist(), "laws": laws})
    if (arrays := _read(kept)) is not None:
        return _truth(arrays)
    start = clock.monotonic()
    truth = case.truth_at(time, parameters)
    if isinstance(truth, Trajectory):
        truth = Converged(trajectory=truth, position_error=0.0, velocity_error=0.0)
    plain = truth is not None and not truth.trajectory.streams and truth.trajectory.contacts is None
    if truth is not None and plain and clock.monotonic() - start > LONG:
        _keep_truth(kept, truth)
    return truth


def bounded(
    case: Case,
    dt: float,
    substep: float,
    parameters: Mapping[str, Any],
    folder: Path | None,
    sources: Mapping[str, str] | None = None,
) -> Case:
    """The case with its bounds as they are at these parameters and a time step dt [s] that the engine takes in steps of
    `substep` [s]; kept under `folder` where they take long."""
    if not any(callable(check.at_most) for check in case.checks):
        return case
    at = {"case": case.name, "bounds at": [dt, substep], "parameters": dict(parameters), "laws": _laws(sources)}
    kept = _place(folder, at)
    if (arrays := _read(kept)) is not None:
        bounds: list[float] = arrays["bounds"].tolist()
    else:
        start = clock.monotonic()
        bounds = [check.bound(dt, case.at(**parameters), substep) for check in case.checks]
        if kept is not None and clock.monotonic() - start > LONG:
            write_arrays(kept, {"bounds": np.array(bounds)})
    return replace(case, checks=tuple(replace(check, at_most=b) for check, b in zip(case.checks, bounds, strict=True)))


def _place(folder: Path | None, depends: Mapping[str, Any]) -> Path | None:
    return None if folder is None else folder / "truths" / f"{digest(depends)}.npz"


def _laws(sources: Mapping[str, str] | None) -> list[str]:
    """The texts that closed forms, bounds and references are made by: of the case, the harness, the reference engine."""
    return (
        [] if sources is None else [sources.get(origin, "") for origin in ("case", "truth", "stepping", "harness", "libraries")]
    )


def _read(kept: Path | None) -> dict[str, Any] | None:
    """The arrays that were kept there; None where there are none, or they are damaged, which is said."""
    try:
        return None if kept is None or not kept.is_file() else read_arrays(kept)
    except Damaged as error:
        print(f"{kept}: {error}; it is made again", file=sys.stderr)
        return None


_STATES = ("time", "p_WB", "q_WB", "v_WB", "w_WB")


def _truth(arrays: Mapping[str, Any]) -> Converged:
    position, velocity = arrays["errors"].tolist()
    states = (arrays[name] for name in _STATES)
    return Converged(trajectory=Trajectory(*states), position_error=position, velocity_error=velocity)


def _keep_truth(kept: Path | None, made: Converged) -> None:
    if kept is not None:
        states = {name: getattr(made.trajectory, name) for name in _STATES}
        write_arrays(kept, states | {"errors": np.array([made.position_error, made.velocity_error])})
