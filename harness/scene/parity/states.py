"""Random states at which two robots are looked at: inside the limits of both, drawn from a seed."""

import numpy as np

from plumbline.harness.scene.parity.facts import JointFacts, RobotFacts
from plumbline.harness.scene.parity.motion import Configuration, first_rates

COUNT = 10
_OPEN = {"revolute": np.pi, "prismatic": 0.5}
"""Half of the range of a joint without limits [rad, m]."""


def drawn(a: RobotFacts, b: RobotFacts, seed: int, count: int = COUNT) -> list[Configuration]:
    """States of the joints of A: uniform inside the limits of A and B, rates within 1 rad/s or m/s and both bounds of speed.

    Balls and free joints are drawn in their rates alone; where the two ranges do not meet, A's is taken.
    """
    rng = np.random.default_rng(seed)
    partners = {joint.name: joint for joint in b.joints}
    pairs = [(joint, partners.get(joint.name, joint)) for joint in a.joints]
    ranges = np.array([_range(*pair) for pair in pairs]).reshape(-1, 2)
    speeds = np.array([_speed(*pair) for pair in pairs])
    starts = first_rates(a)
    sizes = np.diff(starts)
    states = []
    for _ in range(count):
        q = rng.uniform(ranges[:, 0], ranges[:, 1])
        rates = rng.uniform(-1.0, 1.0, starts[-1]) * np.repeat(speeds, sizes)
        states.append(Configuration(q, {}, rates))
    return states


def _range(a: JointFacts, b: JointFacts) -> tuple[float, float]:
    if a.kind not in _OPEN:
        return 0.0, 0.0
    half = _OPEN[a.kind]

    def bounds(*joints: JointFacts) -> tuple[float, float]:
        lower = max((j.lower for j in joints if j.lower is not None), default=None)
        upper = min((j.upper for j in joints if j.upper is not None), default=None)
        if lower is None and upper is None:
            return -half, half
        lower = upper - 2 * half if lower is None and upper is not None else lower
        assert lower is not None
        return max(lower, -1e3), min(lower + 2 * half if upper is None else upper, 1e3)

    low, high = bounds(a, b)
    if low > high:
        low, high = bounds(a)
    return (low, high) if low <= high else (0.0, 0.0)


def _speed(a: JointFacts, b: JointFacts) -> float:
    return min(1.0, *(joint.speed for joint in (a, b) if joint.speed is not None), 1.0)
