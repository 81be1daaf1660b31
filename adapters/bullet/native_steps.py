"""Many steps in one native call: the sub-steps of one that is as many times as long, which are the same bit for bit.

Source: btDiscreteDynamicsWorld::stepSimulation makes floor(t/h) steps of h = length/count and keeps what is left of the time t.
"""

import math

from plumbline.adapters.bullet.vendor import Port

FEWEST = 4
"""Steps from which on one call costs less than as many: it takes two more, that tell the length and take it back."""


def length_of(count: int, h: float) -> float | None:
    """The length [s] of a step that falls into `count` steps of exactly h [s], none lost to rounding; None where none is near."""
    length = count * h
    for _ in range(4):
        if length / count == h and length / h >= count:
            return length
        length = math.nextafter(length, math.inf)
    return None


def advance(port: Port, count: int, h: float) -> None:
    """Steps of h [s], in one call where their number and length allow it."""
    length = length_of(count, h) if count >= FEWEST else None
    if length is None:
        for _ in range(count):
            port.bullet.stepSimulation(physicsClientId=port.client)
        return
    tell = port.bullet.setPhysicsEngineParameter
    tell(fixedTimeStep=length, numSubSteps=count, physicsClientId=port.client)
    port.bullet.stepSimulation(physicsClientId=port.client)
    # pybullet divides impulses by the length that it was told last: forces would come out `count` times too small.
    tell(fixedTimeStep=h, numSubSteps=0, physicsClientId=port.client)
