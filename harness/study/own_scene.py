"""The study of a scene of the user's own: a ladder of time steps on both tracks of every engine, and what the scene calls
for."""

from harness.case import Case
from harness.study.experiment import Experiment
from harness.study.refinement import Refinement
from harness.study.study import Study

__all__ = ["study_of"]

SAMPLE = 0.01
"""Seconds of a timing sample: runs of many engines and steps have to be clocked within the minutes that one waits."""


def study_of(case: Case) -> Study:
    """Where every engine ends in this scene, what that costs at each step, and which effects the scene needs."""
    ladder = Experiment(name="ladder", dt="ladder", refine=Refinement(), sample_seconds=SAMPLE)
    needs = Experiment(name="effects", tracks=("tuned",), effects=True, samples=3, sample_seconds=SAMPLE)
    return Study(name="scene", title=case.title, purpose=case.question, experiments=(ladder, needs))
