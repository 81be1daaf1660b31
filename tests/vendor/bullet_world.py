"""A world of pybullet of one's own, for scripts in the vendor's words."""

from types import TracebackType
from typing import Any, Self

import pytest

pybullet = pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

MULTIBODY, MAXIMAL = 0, 1
"""Generalised coordinates and a free body's own, by the option `useMaximalCoordinates`."""


class World:
    """A private world of pybullet, every call with its client. A new one steps by 1/240 s."""

    def __init__(self) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.disconnect()

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **named: getattr(pybullet, name)(*arguments, **named, physicsClientId=self.client)

    def body(self, shape: int, mass: float, position: tuple[float, float, float], maximal: int, **dynamics: Any) -> int:
        """A body of a collision shape without damping, sleeping and clamp."""
        number: int = self.createMultiBody(mass, shape, basePosition=position, useMaximalCoordinates=maximal)
        if mass > 0:
            dynamics |= {"mass": mass, "localInertiaDiagonal": [mass / 150] * 3}
            self.release(number, maximal)
        self.changeDynamics(number, -1, **dynamics)
        return number

    def release(self, body: int, maximal: int) -> None:
        """Take damping, sleeping and the clamp of 100 rad/s on coordinates off a body."""
        self.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)
        if maximal == MULTIBODY:
            self.changeDynamics(body, -1, maxJointVelocity=1e30)
        else:
            self.changeDynamics(body, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
