"""A stage of regular motions moved, turned and set in uniform motion: is it the same motion?

Newton's laws know no origin, no direction and no state of rest. What finds one is an engine's own: friction along the axes
of the world, damping against the world, a floor whose motion its contacts forget.
"""

from plumbline.harness.case import Axis, Case, Check, Parameters
from plumbline.harness.case.symmetries import Retelling, in_motion, moved, turned
from plumbline.harness.metric import Metric
from plumbline.harness.metrics.equivalence import ATTITUDE_DIFFERENCE, POSITION_DIFFERENCE
from plumbline.harness.props.regular_motions import stage
from plumbline.harness.scene import Scene, axis_angle

DURATION = 1.0
SINGLE = 1e-6
"""Ten roundings of single precision, 6e-8 each, of the metre that things are away and move: more than any tolerance of a solver
should leave, far less than any of the faults that are looked for."""


class P(Parameters):
    speed: float = 1.5


def scene(_: P) -> Scene:
    """A slide, a roll, a swing and a tumbling flight."""
    return stage()


def retellings(p: P) -> tuple[Retelling, ...]:
    """Some metres away; turned by 40 degrees about a skew axis, gravity too; at `speed` [m/s], on a floor that moves alike."""
    original = stage()
    return (
        moved(original, (3.7, -5.1, 0.4)),
        turned(original, axis_angle((1.0, 2.0, 3.0), 0.7)),
        in_motion(original, (0.8 * p.speed, -0.6 * p.speed, 0.0)),
    )


def _check(metric: Metric, because: str) -> Check:
    return Check(metric, SINGLE, f"{because}; what is left are roundings: ten of single precision")


CASE = Case.of(
    globals(),
    title="Another frame",
    question="Is a motion the same some metres away, in another direction, and seen from a moving frame?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 3 (Galileo's relativity principle)",
    truth="conservation",
    hard=Axis(parameter="speed", unit="m/s", easy=0.1, extreme=1000.0, lost=0.1),
    checks=(
        _check(POSITION_DIFFERENCE["moved"], "space is homogeneous"),
        _check(POSITION_DIFFERENCE["turned"], "space is isotropic"),
        _check(POSITION_DIFFERENCE["in_motion"], "no uniform motion is told from rest"),
    ),
    observe=tuple(ATTITUDE_DIFFERENCE[name] for name in ("moved", "turned", "in_motion")),
    headline=POSITION_DIFFERENCE["turned"].name,
)
