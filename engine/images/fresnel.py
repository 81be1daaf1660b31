"""Light at a smooth surface: reflection, refraction, and how much of each.

Source: Born, Wolf, Principles of Optics, sections 1.5.1 (Snell), 1.5.2 (Fresnel) and 1.5.4 (total reflection); Glassner, An
Introduction to Ray Tracing, 1989, section 2.5 (vectors).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec
from plumbline.engine.maths.vec import axpy, dot, norm, scale


@kernel
def reflect(d: Vec, n: Vec) -> Vec:
    """The mirror image of the unit direction d at a surface with unit normal n."""
    out = axpy(-2.0 * dot(d, n), n, d)
    return scale(1.0 / norm(out), out)


@kernel
def refract(d: Vec, n: Vec, ratio: float) -> tuple[bool, Vec]:
    """Snell's law: sine of the new angle = ratio times sine of the old one, ratio = index before / index after.

    Args: d unit; n unit, against d. Returns: whether light passes, and its direction; without, it is totally reflected.
    """
    cosine = -dot(d, n)
    along = axpy(cosine, n, d)
    square = 1.0 - ratio * ratio * dot(along, along)
    if square < 0.0:
        return False, d
    out = axpy(-math.sqrt(square), n, scale(ratio, along))
    return True, scale(1.0 / norm(out), out)


@kernel
def reflectance(cos_in: float, cos_out: float, before: float, after: float) -> float:
    """The share of unpolarised light that a boundary between two indices reflects: the mean of both polarisations' squares."""
    across = (before * cos_in - after * cos_out) / (before * cos_in + after * cos_out)
    within = (after * cos_in - before * cos_out) / (after * cos_in + before * cos_out)
    return 0.5 * (across * across + within * within)
