"""A case's own truth put to the case's own checks, as if it were an engine's answer: what it breaks, no engine can be asked."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.case.case import Case, Check, Converged
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Trajectory

MOST = 1_000_000
"""Bodies times samples of a truth that is tried before a study: more take longer than the trials that they would spare."""


def breaks(check: Check, scene: Scene, truth: Trajectory, bound: float) -> str:
    """How a truth misses a bound, with the figures; '' where it keeps it, or the metric needs more than states.

    Args: truth: at the samples that the check judges, with the step of the answer that they are judged for.
    """
    if check.another_truth:
        return ""
    try:
        value = check.metric(scene, truth, truth)
    except NotMeasurable:
        return ""
    keeps = np.isfinite(value) and (value <= bound if check.metric.better == "lower" else value >= bound)
    return "" if keeps else f"{check.metric.name} of the truth itself is {value:.4g} {check.metric.unit}, bound {bound:.4g}"


def broken_checks(case: Case, dt: float, substep: float | None = None) -> Iterator[str]:
    """How the truth at the case's own parameters misses its own checks at a step dt [s], a sentence for each."""
    scene, interval = case.scene(case.parameters), case.sample_interval or dt
    samples = round(case.duration / interval) + 1
    if case.expected is None or samples * len(scene.bodies) > MOST:
        return
    answer = case.expected(np.arange(samples, dtype=np.float64) * interval, case.parameters)
    if answer is None:
        return
    truth = replace(answer.trajectory if isinstance(answer, Converged) else answer, dt=dt)
    for check in case.checks:
        if reason := breaks(check, scene, check.judged(truth), check.bound(dt, case.parameters, substep)):
            yield reason


def refused(case: Case, parameters: Mapping[str, Any], dt: float) -> str:
    """Why a case does not hold at parameters that are not its own; '' where it does, or they are its own."""
    given = {name: value for name, value in parameters.items() if case.parameters[name] != value and name != "seed"}
    if not given:
        return ""
    altered = ", ".join(f"{name} = {value}" for name, value in given.items())
    try:
        reason = "; ".join(broken_checks(case.put(parameters), dt))
    except (ValueError, ArithmeticError, NotMeasurable) as error:
        reason = f"{type(error).__name__}: {error}"
    return f"case '{case.name}' does not hold at {altered}: {reason}" if reason else ""
