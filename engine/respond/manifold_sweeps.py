"""Sweeps over manifolds: as they were found, or by colours, on one thread or several (`engine.contact.colours`)."""

from numba import prange

from plumbline.engine.compile.jit import kernel, template
from plumbline.engine.contact.colours import cut
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import Bodies, Contacts, bodies_of, contacts_of, shapes_of, some_contacts
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.soft import sweep
from plumbline.engine.respond.softness import PUSH, TURN, Softness, softness_of
from plumbline.engine.respond.substep import warm_start


@kernel
def as_found(floats: Floats, ints: Ints, bodies: Bodies, contacts: Contacts, soft: Softness, aim: int) -> None:
    """Do what `aim` says to some contacts, in their order."""
    if aim == PUSH:
        warm_start(bodies, contacts)
    elif aim == TURN:
        refresh(bodies.state, shapes_of(floats, ints), contacts)
    else:
        sweep(bodies, contacts, soft, aim)


@kernel
def visit_lane(floats: Floats, ints: Ints, aim: int, colour: int, lane: int, lanes: int) -> None:
    """Do what `aim` says to the contacts that a lane of so many has of a colour.

    Tables are carved here, since no tuple of them can be handed to a thread.
    """
    bodies, contacts, bands = bodies_of(floats, ints), contacts_of(floats, ints), ints_of(ints, at.BANDS)
    setting = floats_of(floats, ints, at.SETTING)
    soft = softness_of(setting, setting[0, at.DT] / ints_of(ints, at.COUNT)[0, at.SUBSTEPS])
    lane_contacts = some_contacts(contacts, cut(bands, colour, lane, lanes), cut(bands, colour, lane + 1, lanes))
    as_found(floats, ints, bodies, lane_contacts, soft, aim)


@template
def by_colour(floats: Floats, ints: Ints, _bodies: Bodies, _contacts: Contacts, _soft: Softness, aim: int) -> None:
    """As `as_found`, one colour after the other, with neighbouring bands of a colour on each thread.

    Where there is one thread, none is sent for.
    """
    lanes = min(ints_of(ints, at.TALLY)[0, at.THREADS], at.MOST_BANDS)
    for colour in range(at.COLOURS):
        if lanes == 1:
            visit_lane(floats, ints, aim, colour, 0, 1)
        else:
            for lane in prange(lanes):
                visit_lane(floats, ints, aim, colour, lane, lanes)
