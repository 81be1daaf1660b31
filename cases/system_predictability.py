"""A hundred balls set a billionth to a thousandth of a radian beside the tops of fixed balls: where and when do they roll off?

Near the top a tilt grows like exp(L t), L^2 = 5 g/(7 (R + r)) for a ball that rolls. From a billionth, eight powers of ten lie
before the fall; whatever an engine adds, of rounding, of a solver's tolerance or of jitter, grows alike, and what is larger
than the start decides in its place.
"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, FloatCount, Parameters, Positive
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics import chaos
from plumbline.harness.scene import Body, Scene, Sphere, Surface
from plumbline.harness.trajectory import Floats, Trajectory

FARTHEST = 1e-3
BUMP, RADIUS, MASS, FRICTION = 0.1, 0.05, 1.0, 1.0
DEPTH, SPACING = 1e-6, 0.5
"""How deep [m] a ball stands in its bump at the start, so that it is seen by the first step, and the bumps' distance [m]."""
REACH = BUMP + RADIUS
EXPONENT = float(np.sqrt(5 * G / (7 * REACH)))
DURATION = 3.25
JUDGED = 0.2
"""Up to this tilt [rad] a ball that sticks at all rolls: tan 0.2 is far below the friction."""


class P(Parameters):
    starts: FloatCount = 100
    nearest: Positive = 1e-9
    seed: int = 0


def _starts(starts: float, nearest: float, seed: int) -> tuple[Floats, Floats]:
    """Tilts (n,) and azimuths (n,) rad."""
    count = round(starts)
    return np.geomspace(nearest, FARTHEST, count), np.random.default_rng(seed).uniform(0.0, 2 * np.pi, count)


def _centres(count: int) -> Floats:
    """Of the bumps, (n, 3) m, on a square lattice about the origin."""
    edge = int(np.ceil(np.sqrt(count)))
    index = np.arange(count)
    flat: Floats = SPACING * np.stack([index % edge - (edge - 1) / 2, index // edge - (edge - 1) / 2, np.zeros(count)], axis=1)
    return flat


def scene(p: P) -> Scene:
    """So many balls, each on a bump of its own, at tilts from `nearest` to a thousandth [rad] in random directions."""
    bodies = []
    for k, (tilt, azimuth, centre) in enumerate(
        zip(*_starts(p.starts, p.nearest, p.seed), _centres(round(p.starts)), strict=True)
    ):
        aside = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        bodies += [
            Body.fixed(f"bump_{k}", Sphere(radius=BUMP), material="bump", p_WB=centre.tolist()),
            Body.ball(f"ball_{k}", RADIUS, mass=MASS, material="ball", p_WB=(centre + (REACH - DEPTH) * aside).tolist()),
        ]
    return Scene(bodies=tuple(bodies), surfaces=(Surface.rough(FRICTION, ("ball", "bump")),), apart=(("ball", "ball"),))


def tilts(time: Floats, start: Floats) -> Floats:
    """theta'' = L^2 sin theta from rest, (t, n) rad; each is held where it passes JUDGED, beyond which nothing is said.

    sin(theta/2) = sin(start/2) cosh x, where L t = integral from 0 to x of (1 - m cosh^2)^(-1/2), m = sin^2(start/2): Jacobi's
    nd. Since m is lost beside 1, the root is expanded in m cosh^2 = sin^2(theta/2), at most 0.01, to the third power; what is
    left is 1e-8. The equation for x is solved by Newton's method from x = L t, which lies above.
    """
    small = np.sin(start / 2)
    m, last = small**2, np.arccosh(np.sin(JUDGED / 2) / small)
    due = EXPONENT * time[:, None]
    x = np.minimum(due, last)
    for _ in range(8):
        two, four, six = (np.sinh(k * x) for k in (2, 4, 6))
        integrals = (x / 2 + two / 4, 3 * x / 8 + two / 4 + four / 32, 5 * x / 16 + 15 * two / 64 + 3 * four / 64 + six / 192)
        reached = x + m / 2 * integrals[0] + 3 * m**2 / 8 * integrals[1] + 5 * m**3 / 16 * integrals[2]
        x = np.clip(x - (reached - due) * np.sqrt(1 - m * np.cosh(x) ** 2), 0.0, last)
    angles: Floats = 2 * np.arcsin(small * np.cosh(x))
    return angles


def expected(time: Floats, p: P) -> Trajectory:
    """Rolling without slip down to a tilt of JUDGED, where the balls are left standing: nothing later is judged."""
    start, azimuth = _starts(p.starts, p.nearest, p.seed)
    truth = Trajectory.of(time, 2 * len(start))
    theta = tilts(truth.time, start)
    centres = _centres(len(start))
    truth.p_WB[:, ::2] = centres
    truth.p_WB[:, 1::2] = centres + REACH * np.stack(
        [np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.cos(theta)], axis=-1
    )
    return truth


CASE = Case.of(
    globals(),
    title="On the edge",
    question="How small a difference at the start does an engine carry through to the outcome?",
    source="Landau, Lifshitz, Mechanics, 3rd ed., section 38 (rolling); Ott, Chaos in Dynamical Systems, 2nd ed., section 4.4",
    truth="closed form",
    ladder=(1 / 60, 1 / 90, 1 / 120, 1 / 240, 1 / 480, 1 / 960),
    hard=Axis(parameter="nearest", unit="rad", easy=1e-4, extreme=1e-15),
    checks=(
        Check(
            chaos.growth_exponent_error,
            lambda dt, _: EXPONENT * dt,
            "a first-order method grows by 1 + L dt a step, where exp(L dt) is right: an exponent off by L dt/2, taken "
            "twice for the compliance of contact",
        ),
        Check(
            chaos.lost_start_share,
            0.0,
            "the roundings of double precision turn a line of 0.15 m at 3 m from the origin by 3e-15 rad, a millionth "
            "of the smallest start; and a growth as far off as its bound moves the fall by less than a tenfold start does",
        ),
    ),
    observe=(chaos.smallest_followed_start, chaos.exit_time_error_rms),
)
