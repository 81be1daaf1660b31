"""The impact of a ball on a fixed plane under Newton's and Coulomb's laws for one rigid impulse."""

import numpy as np

from plumbline.harness.trajectory import Floats


def coulomb_impact(
    v_W: Floats, w_W: Floats, mass: float, moment: float, arm: float, restitution: float, friction: float
) -> tuple[Floats, Floats]:
    """Velocity and angular velocity of a ball after it meets the plane z = 0 from above.

    The normal impulse is (1 + e) m |v_z|. The tangential one stops the slip of the point of contact, for which it needs
    slip/(1/m + a^2/I), or has the most that Coulomb's cone gives and points against the slip. Slip keeps its direction in the
    impact of a ball, so that the impulse is the whole law.

    Args:
        v_W, w_W: before the impact, each (3,), m/s and rad/s; v_W falls. mass [kg], moment [kg m2] about any diameter.
        arm [m]: from the centre to the point of contact; the radius, unless the ball is caught off the plane.

    Returns:
        The same after the impact, each (3,).

    Source:
        Stronge, Impact Mechanics, 2nd ed., section 3.2 (sphere); Maw, Barber, Fawcett, Wear 38 (1976) 101 (rigid limit).
    """
    down = np.array([0.0, 0.0, -arm])
    normal = (1 + restitution) * mass * abs(v_W[2])
    slip = (v_W + np.cross(w_W, down)) * np.array([1.0, 1.0, 0.0])
    impulse = -slip / (1 / mass + arm**2 / moment)
    size, most = float(np.linalg.norm(impulse)), friction * normal
    if size > most:
        impulse = impulse * (most / size)
    impulse = impulse + np.array([0.0, 0.0, normal])
    after: tuple[Floats, Floats] = (v_W + impulse / mass, w_W + np.cross(down, impulse) / moment)
    return after
