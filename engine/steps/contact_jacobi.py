"""Steps of worlds with contact, without joints, by Jacobi sweeps: as `contact`, all contacts at once, on any threads."""

from engine.compile.jit import parallel_entry
from engine.constrain.stages import hold_nothing
from engine.maths.rows import Floats, Ints
from engine.respond.jacobi import at_once, split_masses
from engine.steps.contact import advance_contacts
from engine.steps.stages import meet


@parallel_entry
def step_contact_jacobi(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact by Jacobi sweeps. Returns: as `step_contact`."""
    return advance_contacts(floats, ints, steps, meet, split_masses, at_once, hold_nothing)
