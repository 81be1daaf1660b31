"""The study of a scene of the user's own: a ladder of time steps on both tracks of every engine, and what the scene calls
for."""

from plumbline.harness.case import Case
from plumbline.harness.intake.allowance import allowance
from plumbline.harness.study.experiment import Experiment, Refinement
from plumbline.harness.study.study import Study

HALVED = 16
"""What part of the first step the ladder is halved down to at least."""
BUDGET = 120.0
"""Seconds that a person waits for all of it; as many CPU seconds are the ladder's, which has half of the time on two cores."""
SAMPLE = 0.01
"""Seconds of a timing sample: runs of many engines and steps have to be clocked within the minutes that one waits."""


def study_of(case: Case, budget: float | None = None) -> Study:
    """Where every engine ends in this scene, what that costs at each step, and which effects the scene needs.

    The ladder ends at a step at which a run takes as many of them as are allowed, however long it lasts.

    Args: budget [s]: of waiting time, BUDGET if None.
    """
    finest = max(case.dt / HALVED, case.duration / max(allowance().steps - 1, 1))
    refined = Refinement(finest=finest, member_dt=case.ladder[-1], budget=BUDGET if budget is None else budget)
    ladder = Experiment(name="ladder", dt="ladder", refine=refined, sample_seconds=SAMPLE)
    # Effects are told from an engine's own error, so that they are asked about at a step at which it is small.
    needs = Experiment(name="effects", tracks=("tuned",), dt=(case.ladder[1],), effects=True, samples=3, sample_seconds=SAMPLE)
    return Study(name="scene", title=case.title, purpose=case.question, experiments=(ladder, needs))
