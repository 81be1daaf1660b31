"""A stage of regular motions a thousand times smaller and larger under the same gravity: is it the same motion?

With times and speeds that go with the root of the length, every ratio of forces is kept. What tells a millimetre from a
kilometre is a length, a speed or a time of the engine's own: a margin, a slop, a threshold, a clamp, a contact's softness.
"""

from plumbline.harness.case import Axis, Case, Check, Parameters, Positive
from plumbline.harness.case.symmetries import Retelling, scaled
from plumbline.harness.metrics.equivalence import ATTITUDE_DIFFERENCE, POSITION_DIFFERENCE
from plumbline.harness.props.regular_motions import stage
from plumbline.harness.scene import Scene

DURATION = 1.0
SINGLE = 1e-6
"""Ten roundings of single precision, 6e-8 each, of a stage of metres."""


class P(Parameters):
    scale: Positive = 1000.0


def scene(_: P) -> Scene:
    """A slide, a roll, a swing and a tumbling flight, of metres."""
    return stage()


def retellings(p: P) -> tuple[Retelling, ...]:
    """All lengths, and the square of all times, over `scale` and times `scale`."""
    return scaled(stage(), "shrunk", 1 / p.scale), scaled(stage(), "grown", p.scale)


WHY = "Froude's similarity: lengths over g t^2 are the same, so is the motion in its own units; what is left are roundings"

CASE = Case.of(
    globals(),
    title="Millimetres and kilometres",
    question="Does a thing of millimetres or kilometres move like one of metres, in its own units?",
    source="Barenblatt, Scaling (2003), chapter 1 (Froude's similarity)",
    truth="conservation",
    hard=Axis(parameter="scale", unit="1", easy=1.0, extreme=1000.0, lost=0.1),
    checks=(
        Check(POSITION_DIFFERENCE["shrunk"], SINGLE, WHY),
        Check(POSITION_DIFFERENCE["grown"], SINGLE, WHY),
    ),
    observe=(ATTITUDE_DIFFERENCE["shrunk"], ATTITUDE_DIFFERENCE["grown"]),
)
