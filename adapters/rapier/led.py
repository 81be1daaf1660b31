"""Bodies that are led, kept on their path: in single precision the sub-steps of a velocity round it away."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.adapters.rapier.vendor import pose
from plumbline.harness.scene import Body, Quaternion, axis_angle, multiply
from plumbline.harness.trajectory import Floats


@dataclass(slots=True)
class Led:
    """A kinematic body. Terms: p, q: where its path is; v, w: how it goes on until told otherwise [m, m/s, rad/s]."""

    p: Floats
    q: Quaternion
    v: Floats
    w: Floats

    @classmethod
    def of(cls, body: Body) -> "Led":
        """A body at its start."""
        v, w = body.velocity_at_start
        return cls(np.array(body.p_WB), body.q_WB, np.array(v), np.array(w))

    def put_back(self, rapier: Any, view: Any) -> None:
        """Tell the engine's body where its path is. It keeps its velocity."""
        if self.v.any() or self.w.any():
            view.position = pose(rapier, tuple(self.p.tolist()), self.q)

    def go(self, dt: float) -> None:
        """Along the path for dt [s]."""
        self.p = self.p + dt * self.v
        speed = float(np.linalg.norm(self.w))
        if speed > 0:
            x, y, z = (self.w / speed).tolist()
            self.q = multiply(axis_angle((x, y, z), speed * dt), self.q)
