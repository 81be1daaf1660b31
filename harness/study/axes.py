"""What an experiment goes along: the time steps of a case, and the axis that its limit is sought on."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from plumbline.harness.case import Axis, Case
from plumbline.harness.study.experiment import Experiment, Limit, StudyError

BEYOND = 4.0
"""A limit along the time step is sought up to so many times the coarsest step of a case's ladder."""


def axis_of(experiment: Experiment, case: Case) -> Axis:
    """What the limit of an experiment is sought along, with the ends that the experiment sets. Raises: StudyError."""
    return axis_among(experiment, case.name, case.hard, case.ladder, case.parameters)


def axis_among(
    experiment: Experiment, case: str, hard: Axis | None, ladder: Sequence[float], parameters: Mapping[str, Any]
) -> Axis:
    """The same for a case of which these are known. Raises: StudyError."""
    limit = experiment.limit or Limit()
    if limit.along == "dt":
        axis = Axis(parameter="dt", unit="s", easy=min(ladder), extreme=BEYOND * max(ladder))
    elif hard is not None and limit.along in ("axis", hard.parameter):
        axis = hard
    elif limit.along in parameters:
        if limit.easy is None or limit.extreme is None:
            raise StudyError(
                f"experiment '{experiment.name}': limit along '{limit.along}' has no ends, expected easy and extreme"
            )
        axis = Axis(parameter=limit.along, unit="1", easy=limit.easy, extreme=limit.extreme)
    else:
        known = ", ".join(("dt", *parameters))
        raise StudyError(f"experiment '{experiment.name}': case '{case}' has no axis '{limit.along}', expected one of: {known}")
    easy = axis.easy if limit.easy is None else limit.easy
    return replace(axis, easy=easy, extreme=axis.extreme if limit.extreme is None else limit.extreme)


def steps_of(experiment: Experiment, case: Case) -> tuple[float, ...]:
    """The time steps [s] at which an experiment runs a case."""
    if experiment.limit is not None and experiment.limit.along == "dt":
        return (axis_of(experiment, case).easy,)
    if experiment.dt == "case":
        return (case.dt,)
    if experiment.dt == "ladder":
        return case.ladder
    return tuple(experiment.dt)
