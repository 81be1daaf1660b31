"""A round body on a plane with Coulomb friction, along one line: it slides until its slip is gone, then it rolls.

With v along x, w about y, I = k m r^2, the pull s and the load n per mass [m/s2], the slip is u = v - r w and

    sliding:  v' = s - sgn(u) mu n,  r w' = sgn(u) mu n/k;    rolling:  v' = r w' = s/(1 + k), if mu n >= s k/(1 + k).

Source: Landau, Lifshitz, Mechanics, 3rd ed., section 38; Meriam and Kraige, Engineering Mechanics: Dynamics, 7th ed., 6/5.
"""

import numpy as np

from plumbline.harness.trajectory import Floats


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
