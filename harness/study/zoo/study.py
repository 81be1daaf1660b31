"""The study of a zoo: a ladder of time steps for each robot that goes in, on both tracks of every engine."""

from plumbline.harness.case.scene_file import LADDER
from plumbline.harness.study.experiment import Experiment, Refinement
from plumbline.harness.study.study import Study

NAME = "zoo"
BUDGET = 5400.0
"""Seconds that a person waits for all of it: ninety minutes."""
OF_LADDERS = 16.0
"""CPU seconds that the ladders of a robot may take, shared alike by its engines and tracks. With causes, clocking and what
processes cost a robot takes about three times that, so that a hundred fit into the time of two cores."""
HALVED = 8
"""What part of the first step the ladder is halved down to."""


def study_of() -> Study:
    """Where each engine ends with each robot, who agrees, at what cost, and what sets apart those who do not."""
    refined = Refinement(finest=LADDER[0] / HALVED, further=1, budget=OF_LADDERS, turns=4, members=4, member_dt=LADDER[-1])
    ladder = Experiment(name="ladder", dt="ladder", refine=refined, samples=3, sample_seconds=0.01)
    return Study(
        name=NAME,
        title="The zoo",
        purpose="Robots that packages bring along, each put to every engine: does it go in, what has to be left out for that, "
        "do engines agree, what does that cost, and what sets apart those who do not?",
        recordings=False,
        experiments=(ladder,),
    )
