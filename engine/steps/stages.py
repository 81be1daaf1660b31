"""What steps with contact have in common: contacts kept or found, and how long a sub-step is swept."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.contact.find_contacts import find_contacts, keep_contacts
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import Bodies, Contacts
from plumbline.engine.respond.softness import FRESH, FRESH_JOINTED


@kernel
def meet(floats: Floats, ints: Ints, bodies: Bodies, contacts: Contacts) -> int:
    """Keep the contacts of the last step where all bodies are still, else find those of this one. Returns: a status."""
    rest, setting, count = floats_of(floats, ints, at.REST), floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    if keep_contacts(bodies.state, bodies.body, bodies.kind, rest, setting, count, contacts.key, contacts.point):
        return DONE
    return find_contacts(floats, ints)


@kernel
def patience(count: Ints, substep: int, strikes: int) -> int:
    """Times as many sweeps: after a blow, and in the first sub-step with a new contact."""
    if strikes == 0 and (substep > 0 or count[0, at.NEW] == 0):
        return 1
    return FRESH_JOINTED if count[0, at.JOINTS] > 0 else FRESH
