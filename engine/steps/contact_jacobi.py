"""Steps of worlds with contact, without joints, by Jacobi sweeps: as `contact`, all contacts at once, on any threads."""

from plumbline.engine.compile.jit import parallel_entry
from plumbline.engine.constrain.stages import hold_nothing
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.respond.jacobi import at_once, split_masses
from plumbline.engine.steps.contact import advance_contacts
from plumbline.engine.steps.stages import meet


@parallel_entry
def step_contact_jacobi(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact by Jacobi sweeps. Returns: as `step_contact`."""
    return advance_contacts(floats, ints, steps, meet, split_masses, at_once, hold_nothing)
