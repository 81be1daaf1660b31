"""A stage of regular motions far from the origin: what is lost beyond the digits that the numbers lack there?"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters
from plumbline.harness.case.symmetries import Retelling, moved
from plumbline.harness.metrics.equivalence import ATTITUDE_DIFFERENCE, POSITION_DIFFERENCE
from plumbline.harness.props.regular_motions import stage
from plumbline.harness.scene import Scene

DURATION = 1.0


class P(Parameters):
    origin: NotNegative = 1e6


def scene(_: P) -> Scene:
    """A slide, a roll, a swing and a tumbling flight."""
    return stage()


def retellings(p: P) -> tuple[Retelling, ...]:
    """The same `origin` [m] away along x, and some of that along y and z: heights and gaps lose their digits too."""
    return (moved(stage(), (p.origin, -0.7 * p.origin, 0.3 * p.origin)),)


CASE = Case.of(
    globals(),
    title="Far from the origin",
    question="Is a motion the same a thousand kilometres away, to the digits that are left there?",
    source="Goldberg, ACM Computing Surveys 23 (1991) 5, section 1.2 (units in the last place)",
    truth="conservation",
    hard=Axis(parameter="origin", unit="m", easy=1.0, extreme=1e7, lost=0.1),
    checks=(
        Check(
            POSITION_DIFFERENCE["moved"],
            lambda dt, p: float(np.sqrt(3) * (DURATION / dt + 1) * np.spacing(p.origin) / 2),
            "a step rounds each coordinate by at most half the spacing of the numbers there, 1.2e-10 m at 1e6 m: "
            "all roundings the same way, three coordinates, in every sub-step. Velocities are of the size of the stage "
            "and lose nothing; a gap that is wrong by a rounding is righted by as much",
        ),
    ),
    observe=(ATTITUDE_DIFFERENCE["moved"],),
)
