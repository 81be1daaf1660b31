"""The stages of a sub-step in which joints are held, and the holding where there are none, which steps without joints know."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.memory.tables import Bodies, Joints, Rows

BEGIN, NEW, KNOWN, END = range(-1, 3)
"""Rows are written; solved with a new matrix; solved with the matrix of the last call; and rotors keep their rates."""

Held = tuple[int, int]
"""The number of equality rows, and of all rows."""


@kernel
def hold_nothing(_bodies: Bodies, _joints: Joints, _rows: Rows, held: Held, _stage: int, _h: float) -> Held:
    """In place of `hold`, where there are no joints."""
    return held
