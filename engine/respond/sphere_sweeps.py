"""Sweeps over contacts of spheres, as they were found or by colours (`engine.contact.colours`), on one thread or several."""

from numba import prange

from plumbline.engine.compile.jit import kernel, template
from plumbline.engine.contact.colours import cut
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.respond.softness import PRESS, PUSH, TURN, Softness, softness_of
from plumbline.engine.respond.spheres import Touches, press_spheres, push_again, relax_spheres, touches_of, turn_normals


@template
def visit(floats: Floats, ints: Ints, touches: Touches, first: int, end: int, soft: Softness, aim: int, share: float) -> bool:
    """Do what `aim` says to the contacts first..end - 1, in rising rows.

    Args: share: as that of `push_again`. Returns: as `relax_spheres`.
    """
    slipping = False
    if aim == PRESS:
        press_spheres(touches, first, end, soft)
    elif aim == PUSH:
        push_again(touches, first, end, share)
    elif aim == TURN:
        turn_normals(touches, first, end, floats_of(floats, ints, at.STATE))
    else:
        slipping = relax_spheres(touches, first, end, aim)
    return slipping


@kernel
def visit_lane(floats: Floats, ints: Ints, aim: int, share: float, colour: int, lane: int, lanes: int) -> bool:
    """Do what `aim` says to the contacts that a lane of so many has of a colour. Returns: as `relax_spheres`.

    Tables are carved here, since no tuple of them can be handed to a thread.
    """
    touches, bands, setting = touches_of(floats, ints), ints_of(ints, at.BANDS), floats_of(floats, ints, at.SETTING)
    soft = softness_of(setting, setting[0, at.DT] / ints_of(ints, at.COUNT)[0, at.SUBSTEPS])
    first, end = cut(bands, colour, lane, lanes), cut(bands, colour, lane + 1, lanes)
    return visit(floats, ints, touches, first, end, soft, aim, share)


@template
def as_found(floats: Floats, ints: Ints, touches: Touches, soft: Softness, aim: int, share: float) -> bool:
    """As `visit`, of all contacts."""
    return visit(floats, ints, touches, 0, ints_of(ints, at.COUNT)[0, at.MANIFOLDS], soft, aim, share)


@template
def by_colour(floats: Floats, ints: Ints, _touches: Touches, _soft: Softness, aim: int, share: float) -> bool:
    """As `as_found`, one colour after the other, with neighbouring bands of a colour on each thread.

    Where there is one thread, none is sent for.
    """
    bands, lanes, slipping = ints_of(ints, at.BANDS), min(ints_of(ints, at.TALLY)[0, at.THREADS], at.MOST_BANDS), False
    for lane in range(lanes):
        bands[lane, at.SLIPPING] = 0
    for colour in range(at.COLOURS):
        if lanes == 1:
            slipping = visit_lane(floats, ints, aim, share, colour, 0, 1) or slipping
        else:
            for lane in prange(lanes):
                if visit_lane(floats, ints, aim, share, colour, lane, lanes):
                    bands[lane, at.SLIPPING] = 1
    for lane in range(lanes):
        slipping = slipping or bands[lane, at.SLIPPING] == 1
    return slipping
