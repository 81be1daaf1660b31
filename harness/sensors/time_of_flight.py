"""Time of flight: the phase of modulated light gives the range, again from 0 beyond half the modulation's wavelength.

The standard deviation is range_sigma + range_sigma_slope r, and beside it, in squares, shot_sigma sqrt(A + B)/A for the light
A of the lamp and B of the sun that come back (photons of both make noise, those of the lamp alone carry the phase). The
disturbed range is wrapped into 0..R.

One indirect path may be added: the point that a mirror at the seen point would show is lit by the lamp and lights the seen
point. Its light has travelled half of (camera to that point, on to the seen point, and back) as a range, and adds as a phasor
of strength multipath times what that point scatters. The sum's phase is what is measured.

Invalid is what sends too little light back (dark, far, grazing, mirrors, glass), or too little beside sunlight.

Source: Lange, 3D Time-of-Flight Distance Measurement (2000), chapters 2 (phase, wrap) and 4 (photon noise); Hansard, Lee, Choi,
Horaud, Time-of-Flight Cameras (2012), chapter 1; Fuchs, Multipath Interference Compensation in Time-of-Flight Camera Images,
ICPR 2010 (one reflection between surfaces).
"""

import numpy as np

from plumbline.harness.scene import TimeOfFlightNoise
from plumbline.harness.sensors.sight import Mask, Sight, lifted, signal, sunlight, too_faint
from plumbline.harness.trajectory import Floats


def lost(noise: TimeOfFlightNoise, sight: Sight) -> Mask:
    """Which measurable pixels are invalid by optics, (r,). Raises: Unsupported."""
    return too_faint(sight, noise.least_signal, noise.least_contrast)


def sigma(noise: TimeOfFlightNoise, sight: Sight) -> Floats:
    """Standard deviation of the range [m], (r,); 0 where a pixel is not measurable, inf where no light comes back.

    Raises: Unsupported.
    """
    measurable = sight.measurable
    steady = noise.range_sigma + noise.range_sigma_slope * np.where(measurable, sight.range, 0.0)
    if noise.shot_sigma == 0.0:
        return np.where(measurable, steady, 0.0)
    lamp, sun = signal(sight), sunlight(sight)
    with np.errstate(divide="ignore", invalid="ignore"):
        shot = np.where(lamp > 0.0, noise.shot_sigma * np.sqrt(lamp + sun) / lamp, np.inf)
    return np.where(measurable, np.hypot(steady, shot), 0.0)


def mixed_range(direct: Floats, indirect: Floats, strength: Floats, unambiguous: float) -> Floats:
    """Range [m] in 0..unambiguous read off exp(i p) + strength exp(i p'), p = 2 pi range / unambiguous; all (r,)."""
    turn = 2.0 * np.pi / unambiguous
    # The direct path's phase is taken out, so that without a second one its range comes back to the last bit.
    lead = np.angle(1.0 + strength * np.exp(1j * turn * (indirect - direct))) / turn
    mixed: Floats = np.mod(direct + lead, unambiguous)
    return mixed


def _with_detour(noise: TimeOfFlightNoise, sight: Sight, direct: Floats, unambiguous: float) -> Floats:
    facing, directions = sight.facing_W, sight.directions_W
    mirrored = directions - 2.0 * np.sum(directions * facing, axis=1)[:, None] * facing
    start, asked = lifted(sight), sight.measurable
    hits = sight.cast(start[asked], np.ascontiguousarray(mirrored[asked]), 1.001 * sight.camera.far / float(sight.ahead.min()))
    met = np.isfinite(hits.distance)
    on = np.where(met, hits.distance, 0.0)
    other_W = start[asked] + on[:, None] * mirrored[asked]
    travelled = np.linalg.norm(other_W - sight.p_WS, axis=1) + on + direct[asked]
    white = np.array([*(body.appearance.reflectivity * body.appearance.scatters for body in sight.scene.bodies), 0.0])
    mixed = direct.copy()
    mixed[asked] = mixed_range(direct[asked], travelled / 2.0, noise.multipath * white[hits.body] * met, unambiguous)
    return mixed


def answer(noise: TimeOfFlightNoise, sight: Sight, normal: Floats) -> Floats:
    """z-depth [m] of all pixels as if all were valid, (r,), from standard normal deviates (r,).

    Raises: Unsupported.
    """
    measurable, unambiguous = sight.measurable, noise.unambiguous_range
    spread = sigma(noise, sight)
    measured = np.where(measurable, sight.range, 0.0)
    if unambiguous is not None and noise.multipath > 0.0:
        measured = _with_detour(noise, sight, measured, unambiguous)
    # A pixel without any light is invalid; its infinite deviation must not become NaN on the way there.
    measured = measured + np.where(np.isinf(spread), 0.0, spread) * normal
    if unambiguous is not None:
        measured = np.mod(measured, unambiguous)
    return np.where(measurable, measured * sight.ahead, sight.depth)
