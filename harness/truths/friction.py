"""A round body on a plane with Coulomb friction, along one line: it slides until its slip is gone, then it rolls.

With v along x, w about y, I = k m r^2, the pull s and the load n per mass [m/s2], the slip is u = v - r w and

    sliding:  v' = s - sgn(u) mu n,  r w' = sgn(u) mu n/k;    rolling:  v' = r w' = s/(1 + k), if mu n >= s k/(1 + k).

Source: Landau, Lifshitz, Mechanics, 3rd ed., section 38; Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., 6/5.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory


def grip_time(speed: float, rim: float, friction: float, factor: float, pull: float, load: float) -> float:
    """The instant [s] at which a slip ends; inf where it does not.

    Args: speed v and rim r w [m/s] at the start; friction mu; factor k; pull s and load n [m/s2].
    """
    slip = speed - rim
    if slip == 0:
        return 0.0
    closing = friction * load * (1 + 1 / factor) - np.sign(slip) * pull
    return float(abs(slip) / closing) if closing > 0 else float("inf")


def rolling(
    time: Floats, speed: float, rim: float, friction: float, factor: float, pull: float, load: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Way [m], speed v [m/s], angle of the rim r phi [m] and its speed r w [m/s] at each time, each (t,).

    Args: as `grip_time`. Raises: ValueError where a body loses its grip a second time, in the other direction.
    """
    t = np.asarray(time, dtype=np.float64)
    until = grip_time(speed, rim, friction, factor, pull, load)
    way = np.sign(speed - rim)
    if way == 0 and friction * load < abs(pull) * factor / (1 + factor):
        way, until = np.sign(pull), float("inf")
    here = np.minimum(t, until)
    slows, spins = pull - way * friction * load, way * friction * load / factor
    v, w = speed + slows * here, rim + spins * here
    x, turned = (speed + slows * here / 2) * here, (rim + spins * here / 2) * here
    if np.isfinite(until):
        if friction * load < abs(pull) * factor / (1 + factor):
            raise ValueError(f"friction {friction} lets the body slip again after {until:.6g} s")
        since, gain = t - here, pull / (1 + factor)
        x, turned = x + (v + gain * since / 2) * since, turned + (w + gain * since / 2) * since
        v, w = v + gain * since, w + gain * since
    return x, v, turned, w


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


def resting(scene: Callable[[Any], Scene]) -> Callable[[Floats, Any], Trajectory]:
    """The truth of a case in whose scene nothing moves."""
    return lambda time, parameters: Trajectory.at_rest(scene(parameters), time)
