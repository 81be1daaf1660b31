"""Steps of worlds with contact, without joints, swept by colours: as `contact`, in another order, on one thread or several."""

from plumbline.engine.compile.jit import parallel_entry
from plumbline.engine.constrain.stages import hold_nothing
from plumbline.engine.contact.colours import mark_manifolds
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.respond.manifold_sweeps import by_colour
from plumbline.engine.steps.contact import advance_contacts
from plumbline.engine.steps.stages import meet


@parallel_entry
def step_contact_coloured(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact, swept by colours. Returns: as `step_contact`."""
    return advance_contacts(floats, ints, steps, meet, mark_manifolds, by_colour, hold_nothing)
