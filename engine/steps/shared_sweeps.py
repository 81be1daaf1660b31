"""Steps of worlds with contact, without joints, whose sweeps threads may share: by colours, or over all contacts at once."""

from plumbline.engine.compile.jit import parallel_entry
from plumbline.engine.constrain.stages import hold_nothing
from plumbline.engine.contact.colours import mark_manifolds, mark_touches
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.respond import manifold_sweeps, sphere_sweeps
from plumbline.engine.respond.jacobi import at_once, split_masses
from plumbline.engine.steps.contact import advance_contacts
from plumbline.engine.steps.spheres import advance_spheres
from plumbline.engine.steps.stages import meet


@parallel_entry
def step_contact_coloured(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact, swept by colours: as `contact`, in another order. Returns: as `step_contact`, as below."""
    return advance_contacts(floats, ints, steps, meet, mark_manifolds, manifold_sweeps.by_colour, hold_nothing)


@parallel_entry
def step_contact_jacobi(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact by Jacobi sweeps: as `contact`, all contacts at once."""
    return advance_contacts(floats, ints, steps, meet, split_masses, at_once, hold_nothing)


@parallel_entry
def step_spheres_coloured(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance spheres in contact, swept by colours: as `spheres`, in another order."""
    return advance_spheres(floats, ints, steps, mark_touches, sphere_sweeps.by_colour)
