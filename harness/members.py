"""The starts of an ensemble: one scene, each time caught at another phase of its steps and built a little otherwise.

Whether a run breaks depends on chance that no question means to ask about: where in a step a contact falls, which way the axes
of a box point, in which order rounding errors come. So each member starts

* turned about the vertical by an angle of its own: nothing in nature knows x from y, but friction pyramids and axis-aligned
  bounds do;
* later by a share of a step: each free body that moves stands where it was up to one step before, so that impacts fall
  anywhere in a step;
* built with tolerances: each free body stands off its place by up to `TOLERANCE` of its width. Joints stay whole.

All of it is drawn from the member's number alone, so that every engine and every setting gets the same starts.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from harness.retelling import Retelling, turned
from harness.scene import Body, Scene, axis_angle, width
from harness.trajectory import Trajectory

__all__ = ["TOLERANCE", "Member", "member"]

TOLERANCE = 1e-4
"""Of a body's width: a tenth of a millimetre at a metre, what a machine shop holds (ISO 2768-1 fine, 0.1..0.15 mm at 1 m)."""


@dataclass(frozen=True, slots=True)
class Member:
    """One start. Terms: scene: what is run. told: how the turned scene is told back; None where it is not turned."""

    scene: Scene
    told: Retelling | None

    def back(self, run: Trajectory) -> Trajectory:
        """The motion in the words of the case's own scene; contacts keep their depths, but their places stay turned."""
        return run if self.told is None else self.told.back(run)


def member(scene: Scene, number: int, dt: float, turn: bool = True) -> Member:
    """Member `number` of the ensemble of a scene that is run at steps of dt [s]; `turn` says whether it may be turned."""
    draw = np.random.default_rng(number)
    angle, phase = float(draw.uniform(0.0, 2 * math.pi)), float(draw.uniform())
    joined = {name for joint in scene.joints for name in (joint.parent, joint.child)}

    def moved(body: Body) -> Body:
        off = draw.uniform(-1.0, 1.0, 3)
        if not body.movable or body.name in joined:
            return body
        size = min((width(placed.shape) for placed in body.collision), default=0.0)
        where = np.array(body.p_WB) - phase * dt * np.array(body.v_WB)
        where += TOLERANCE * (size if math.isfinite(size) else 0.0) * off
        return replace(body, p_WB=(float(where[0]), float(where[1]), float(where[2])))

    varied = replace(scene, bodies=tuple(moved(body) for body in scene.bodies))
    told = turned(varied, axis_angle((0.0, 0.0, 1.0), angle)) if turn else None
    return Member(varied if told is None else told.scene, told)
