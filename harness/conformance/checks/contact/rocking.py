"""Checks of curvature: an ellipsoid that rocks on a level ground takes the time that its curvature at the lowest point says."""

from math import cos, pi, sin, sqrt

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Unsupported
from harness.conformance.check import Finding, NotApplicable, check, judge, near
from harness.conformance.runs import FINE, record
from harness.conformance.scenes import G, on_ground
from harness.scene import Body, Ellipsoid, PlacedShape, axis_angle, ellipsoid_inertia

_AXES = (0.2, 0.15, 0.1)
"""Semi-axes [m]: along the way that it rocks, across, and up."""
_TILT = 0.05
"""Largest tilt [rad]; it changes the period by less than its square."""


def rocking_period(a: float, c: float) -> float:
    """The period [s] of small rocking without slip of a solid ellipsoid with semi-axes a along and c up [m].

    The height sqrt(a^2 sin^2 t + c^2 cos^2 t) of its centre is a spring m g (a^2 - c^2)/c, and its inertia about the ground
    m (a^2 + c^2)/5 + m c^2. Source: Goldstein, Classical Mechanics, 3rd ed., section 6.2 (small oscillations).
    """
    return 2 * pi * sqrt(c * (a**2 + 6 * c**2) / (5 * G * (a**2 - c**2)))


@check("Does an ellipsoid that rocks have the period that its curvature gives it?", Feature.ELLIPSOID)
def ellipsoid_rocks_by_its_curvature(adapter: Adapter, settings: Settings) -> Finding:
    """Let go at a tilt, it is level four times within two periods, at a quarter and every half of one later."""
    a, _, c = _AXES
    height = sqrt((a * sin(_TILT)) ** 2 + (c * cos(_TILT)) ** 2)
    body = Body(
        name="rocker",
        inertia=ellipsoid_inertia(1.0, _AXES),
        collision=(PlacedShape(shape=Ellipsoid(semi_axes=_AXES)),),
        material="block",
        p_WB=(0.0, 0.0, height),
        q_WB=axis_angle((0.0, 1.0, 0.0), _TILT),
    )
    period = rocking_period(a, c)
    try:
        run = record(adapter, on_ground(adapter, body, friction=1.0), settings.with_dt(FINE), 2 * period)
    except Unsupported as refusal:
        raise NotApplicable(f"refused: {refusal}") from refusal
    w, y = run.q_WB[:, 1, 0], run.q_WB[:, 1, 2]
    tilt = 2 * np.arctan2(y * np.sign(w), np.abs(w))
    falls = np.flatnonzero(tilt[:-1] * tilt[1:] < 0)
    level = run.time[falls] + FINE * tilt[falls] / (tilt[falls] - tilt[falls + 1])
    because = "its tilt and soft contacts change the period by less than a hundredth; facets or another curvature by tenths"
    expected = period * (0.25 + 0.5 * np.arange(4))
    return judge(near("times at which it is level [s]", level[:4], expected, 0.02 * period, because))
