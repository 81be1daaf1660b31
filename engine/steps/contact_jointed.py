"""Steps of worlds with contact and joints: as `contact`, each sweep over contacts followed by a direct solve of all joints."""

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.constrain.hold_joints import hold
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.contact.colours import leave_as_found
from plumbline.engine.contact.find_contacts import find_contacts
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import bodies_of, joints_of
from plumbline.engine.respond.manifold_sweeps import as_found
from plumbline.engine.steps.contact import advance_contacts


@kernel
def meet_jointed(floats: Floats, ints: Ints) -> int:
    """Find the contacts of this step, and let joints touch their bodies. Returns: a status."""
    status, bodies, joints = find_contacts(floats, ints), bodies_of(floats, ints), joints_of(floats, ints)
    if status == DONE:
        for j in range(joints.kind.shape[0]):
            bodies.kind[joints.kind[j, at.PARENT], at.TOUCHED] = 1
            bodies.kind[joints.kind[j, at.CHILD], at.TOUCHED] = 1
        clear_reactions(joints)
    return int(status)


@entry
def step_contact_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints. Returns: as `step_contact`, and `open_joint`."""
    done, status = advance_contacts(floats, ints, steps, meet_jointed, leave_as_found, as_found, hold)
    return done, open_joint(floats, ints, touching=True) if status == DONE else status
