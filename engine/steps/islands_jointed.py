"""Steps of worlds with contact and joints, island by island: one after the other, or on several threads."""

from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.constrain.hold_joints import hold
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.islands.contacts import make_room_for_rows
from plumbline.engine.islands.stages import begin_islands, in_turn, on_threads, step_by_islands
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import Joints, joints_of


@kernel
def begin(floats: Floats, ints: Ints) -> int:
    """As `begin_islands`, with room for the rows of every island, whose joints have carried nothing yet."""
    status, joints = begin_islands(floats, ints, keeping=False), joints_of(floats, ints)
    if status == DONE:
        make_room_for_rows(ints)
        held = ints_of(ints, at.SPAN_OF_ISLAND)[ints_of(ints, at.TALLY)[0, at.ISLANDS], at.FIRST_JOINT]
        clear_reactions(Joints(joints.joint, joints.kind, joints.order[:held]))
    return status


@entry
def step_islands_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints, one island after the other.

    Returns: as `step_islands`, and `open_joint`.
    """
    done, status = step_by_islands(floats, ints, steps, begin, in_turn, hold)
    return done, open_joint(floats, ints, touching=True) if status == DONE else status


@parallel_entry
def step_islands_jointed_parallel(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """As `step_islands_jointed`, on several threads."""
    done, status = step_by_islands(floats, ints, steps, begin, on_threads, hold)
    return done, open_joint(floats, ints, touching=True) if status == DONE else status
