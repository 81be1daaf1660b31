"""Steps of worlds with contact and joints: as `contact`, each sweep over contacts followed by a direct solve of all joints."""

from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.hold_joints import hold
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.contact.colours import leave_as_found
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory.status import DONE
from plumbline.engine.respond.manifold_sweeps import as_found
from plumbline.engine.steps.contact import advance_contacts
from plumbline.engine.steps.stages import meet_jointed


@entry
def step_contact_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints. Returns: as `step_contact`, and `open_joint`."""
    done, status = advance_contacts(floats, ints, steps, meet_jointed, leave_as_found, as_found, hold)
    return done, open_joint(floats, ints, touching=True) if status == DONE else status
