"""The compiled parts of an exact step that joints add: their rows, and a last look at their gaps."""

from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory.tables import bodies_of, joints_of, rows_of


@entry
def write_joint_rows(floats: Floats, ints: Ints, h: float) -> tuple[int, int]:
    """Write the rows of all joints for the present pose, over h seconds. Returns: how many are equalities, and of all."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    equalities = equality_rows(bodies.state, joints, rows)
    return equalities, bounded_rows(bodies.state, joints, rows, equalities, h, stiff_alone=False)


@entry
def look_at_joints(floats: Floats, ints: Ints) -> int:
    """Returns: as `open_joint`."""
    return open_joint(floats, ints, touching=True)
