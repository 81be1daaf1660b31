"""What becomes of rays of light, followed backwards, where they meet a surface: light that arrives there, and rays that go on.

A ray at a surface with mirror m and transmission t goes on as a mirrored ray with the share m, as the two rays of Fresnel's
equations with (1 - m) t between them, and ends in scattering with (1 - m)(1 - t). A ray that is given up is said to see the
sky: where everything sends back all light, a picture under a sky alone is as bright as the sky, however early that happens.

Source: Whitted, An Improved Illumination Model for Shaded Display, 1980 (rays that branch); Pharr, Jakob, Humphreys, Physically
Based Rendering, 2016, section 13.6 (directions by their cosine); Roberts, The Unreasonable Effectiveness of Quasirandom
Sequences, 2018 (the shifts); Born, Wolf, Principles of Optics, sections 1.5.1 (Snell), 1.5.2 (Fresnel) and 1.5.4 (total
reflection); Glassner, An Introduction to Ray Tracing, 1989, section 2.5 (vectors).
"""

import math
from typing import NamedTuple

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.images.tables import Lighting
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, cross, dot, neg, norm, perpendicular, scale
from plumbline.engine.rays.hits import Hits


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


GIVEN, MIRRORED, REFLECTED, REFRACTED, SCATTERED = 0, 1, 2, 3, 4
"""How a ray came to be."""
AIR = 1.0
LEAST = 1e-4
"""Weight [1] below which a ray is given up."""
STEP = 1e-13
"""Share of the coordinates and of the way [1] by which a ray starts off the surface that it leaves: some hundred roundings."""
GOLDEN, PLASTIC = 0.6180339887498949, 0.7548776662466927
"""Shares of 1 [1] whose multiples spread evenly in one and, with their squares, in two dimensions."""


class Generation(NamedTuple):
    """Rays of light that are equally many surfaces away from the eye.

    Terms:
        origins (n, 3) or (1, 3) m, directions (n, 3), light (n, 5): weight in red, green and blue, index of the medium around
        the ray, and of what is around that; roots (n, 3): row of radiance, ray of the generation before, how it came to be.
    """

    origins: Floats
    directions: Floats
    light: Floats
    roots: Ints


class ShadowRays(NamedTuple):
    """Points that ask for the sun: origins (n, 3) m, gain (n, 3): radiance if nothing keeps it off; roots (n,): whose it is."""

    origins: Floats
    gain: Floats
    roots: Ints


class Branch(NamedTuple):
    """One way on from a surface.

    Terms:
        kind: how the ray comes to be; origin [m], direction; share [1] of red, green and blue that goes this way; around, outer
        [1]: index of the medium around the ray, and of what is around that.
    """

    kind: int
    origin: Vec
    direction: Vec
    share: Vec
    around: float
    outer: float


@kernel
def go_on(k: int, parent: int, branch: Branch, rays: Generation, after: Generation, sky: float, radiance: Floats) -> int:
    """Write ray k of the generation after, or let it see the sky if its weight is too small. Returns: the number of rays."""
    light, roots, share = rays.light, rays.roots, branch.share
    if max(share[0], share[1], share[2]) <= 0.0:
        return k
    weight = (share[0] * light[parent, 0], share[1] * light[parent, 1], share[2] * light[parent, 2])
    if max(weight[0], weight[1], weight[2]) < LEAST:
        for c in range(3):
            radiance[roots[parent, 0], c] += weight[c] * sky
        return k
    store3(after.origins, k, 0, branch.origin)
    store3(after.directions, k, 0, branch.direction)
    store3(after.light, k, 0, weight)
    after.light[k, 3], after.light[k, 4] = branch.around, branch.outer
    after.roots[k, 0], after.roots[k, 1], after.roots[k, 2] = roots[parent, 0], parent, branch.kind
    return k + 1


@kernel
def grey(share: float) -> Vec:
    """The same share [1] of red, green and blue."""
    return share, share, share


@kernel
def towards_sky(n: Vec, k: int, count: int, place: int) -> Vec:
    """Direction k of `count` about the normal, as likely as its cosine: a spiral, shifted from place to place."""
    a, b = (place * PLASTIC + k * GOLDEN) % 1.0, (place * PLASTIC * PLASTIC + (k + 0.5) / count) % 1.0
    angle = 2.0 * math.pi * a
    x = perpendicular(n)
    c, s = cos_sin(angle)
    flat = axpy(c, x, scale(s, cross(n, x)))
    d = axpy(math.sqrt(b), flat, scale(math.sqrt(1.0 - b), n))
    return scale(1.0 / norm(d), d)


@entry
def scatter(
    rays: Generation, hits: Hits, lighting: Lighting, sky_rays: int, sample: int, radiance: Floats, after: Generation,
    shadow: ShadowRays,
) -> tuple[int, int]:  # fmt: skip
    """Follow rays one surface further.

    Args:
        hits: what they meet. sky_rays: directions in which a scattering point looks for the sky, another set for each sample of
        a pixel. radiance (pixels, 3): what the rays bring. after: room for the rays that go on; without any room none does.
        shadow: room for as many rays as there are.
    Returns: how many rays go on, and how many ask for the sun.
    """
    origins, directions, light, roots = rays
    distance, body, _, normal = hits
    optics, sun = lighting
    towards, irradiance, sky = load3(sun, 0, 0), sun[0, 3], sun[0, 4]
    more, asking = 0, 0
    one, last = origins.shape[0] == 1, after.directions.shape[0] == 0
    for r in range(directions.shape[0]):
        root = roots[r, 0]
        b = body[r]
        if b < 0:
            for c in range(3):
                radiance[root, c] += light[r, c] * sky
            continue
        way = load3(directions, r, 0)
        d = scale(1.0 / norm(way), way)
        p = axpy(distance[r], d, load3(origins, 0 if one else r, 0))
        outward = load3(normal, r, 0)
        inside = dot(d, outward) > 0.0
        n = neg(outward) if inside else outward
        step = STEP * (1.0 + max(abs(p[0]), abs(p[1]), abs(p[2]), distance[r]))
        above, below = axpy(step, n, p), axpy(-step, n, p)
        mirror, clear, index = optics[b, 3], (1.0 - optics[b, 3]) * optics[b, 4], optics[b, 5]
        plain = (1.0 - mirror) * (1.0 - optics[b, 4])
        if last:
            for c in range(3):
                radiance[root, c] += (mirror + clear) * light[r, c] * sky
        else:
            around, outer = light[r, 3], light[r, 4]
            if mirror > 0.0:
                branch = Branch(MIRRORED, above, reflect(d, n), grey(mirror), around, outer)
                more = go_on(more, r, branch, rays, after, sky, radiance)
            if clear > 0.0:
                before, behind = (index, outer) if inside else (around, index)
                passes, through = refract(d, n, before / behind)
                back = reflectance(-dot(d, n), -dot(through, n), before, behind) if passes else 1.0
                branch = Branch(REFLECTED, above, reflect(d, n), grey(clear * back), before if inside else around, outer)
                more = go_on(more, r, branch, rays, after, sky, radiance)
                if passes:
                    share = grey(clear * (1.0 - back))
                    branch = Branch(REFRACTED, below, through, share, behind, AIR if inside else around)
                    more = go_on(more, r, branch, rays, after, sky, radiance)
        if plain <= 0.0:
            continue
        colour = load3(optics, b, 0)
        cosine = dot(n, towards)
        if irradiance > 0.0 and cosine > 0.0:
            store3(shadow.origins, asking, 0, above)
            for c in range(3):
                shadow.gain[asking, c] = light[r, c] * plain * colour[c] * irradiance / math.pi * cosine
            shadow.roots[asking] = root
            asking += 1
        if sky_rays == 0 or last or roots[r, 2] == SCATTERED:
            for c in range(3):
                radiance[root, c] += light[r, c] * plain * colour[c] * sky
            continue
        for k in range(sky_rays):
            way = towards_sky(n, k, sky_rays, root + 7919 * sample)
            branch = Branch(SCATTERED, above, way, scale(plain / sky_rays, colour), light[r, 3], light[r, 4])
            more = go_on(more, r, branch, rays, after, sky, radiance)
    return more, asking


@entry
def add_unshaded(distance: Floats, shadow: ShadowRays, radiance: Floats) -> None:
    """Add what each asking point gains from the sun, unless something stands between, at distance (asking,) m."""
    for r in range(len(distance)):
        if distance[r] == math.inf:
            for c in range(3):
                radiance[shadow.roots[r], c] += shadow.gain[r, c]
