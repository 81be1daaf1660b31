"""Steps of worlds of spheres whose contacts are swept by colours: as `spheres`, in another order, on one thread or several."""

from plumbline.engine.compile.jit import parallel_entry
from plumbline.engine.contact.colours import mark_touches
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.respond.sphere_sweeps import by_colour
from plumbline.engine.steps.spheres import advance_spheres


@parallel_entry
def step_spheres_coloured(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance spheres in contact, swept by colours. Returns: as `step_contact`."""
    return advance_spheres(floats, ints, steps, mark_touches, by_colour)
