"""Sweeps over manifolds: as they were found, or by colours, on one thread or several (`engine.contact.colours`)."""

from numba import prange

from engine.compile.jit import kernel, template
from engine.contact.colours import cut
from engine.maths.vec import Floats, Ints
from engine.memory.arena import BANDS, COLOURS, COUNT, DT, MANIFOLDS, MOST_BANDS, SETTING, SUBSTEPS, TALLY, THREADS
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import Bodies, Contacts, bodies_of, contacts_of, shapes_of
from engine.respond.arms import refresh
from engine.respond.soft import sweep
from engine.respond.softness import PUSH, TURN, Softness, softness_of
from engine.respond.substep import warm_start

__all__ = ["as_found", "by_colour"]


@kernel
def visit_lane(floats: Floats, ints: Ints, aim: int, colour: int, lane: int, lanes: int) -> None:
    """Do what `aim` says to the contacts that a lane of so many has of a colour.

    Tables are carved here, since no tuple of them can be handed to a thread.
    """
    bodies, contacts, bands = bodies_of(floats, ints), contacts_of(floats, ints), ints_of(ints, BANDS)
    setting = floats_of(floats, ints, SETTING)
    soft = softness_of(setting, setting[0, DT] / ints_of(ints, COUNT)[0, SUBSTEPS])
    first, end = cut(bands, colour, lane, lanes), cut(bands, colour, lane + 1, lanes)
    if aim == PUSH:
        warm_start(bodies, contacts, end, first)
    elif aim == TURN:
        refresh(bodies.state, shapes_of(floats, ints), contacts, end, first)
    else:
        sweep(bodies, contacts, end, soft, aim, first)


@template
def as_found(floats: Floats, ints: Ints, bodies: Bodies, contacts: Contacts, soft: Softness, aim: int) -> None:
    """Do what `aim` says to all contacts, in rising rows."""
    n = ints_of(ints, COUNT)[0, MANIFOLDS]
    if aim == PUSH:
        warm_start(bodies, contacts, n)
    elif aim == TURN:
        refresh(bodies.state, shapes_of(floats, ints), contacts, n)
    else:
        sweep(bodies, contacts, n, soft, aim)


@template
def by_colour(floats: Floats, ints: Ints, _bodies: Bodies, _contacts: Contacts, _soft: Softness, aim: int) -> None:
    """As `as_found`, one colour after the other, with neighbouring bands of a colour on each thread.

    Where there is one thread, none is sent for.
    """
    lanes = min(ints_of(ints, TALLY)[0, THREADS], MOST_BANDS)
    for colour in range(COLOURS):
        if lanes == 1:
            visit_lane(floats, ints, aim, colour, 0, 1)
        else:
            for lane in prange(lanes):
                visit_lane(floats, ints, aim, colour, lane, lanes)
