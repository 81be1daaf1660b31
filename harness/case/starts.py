"""The starts of an ensemble: one scene, each time caught at another phase of its steps and built a little otherwise.

Whether a run breaks depends on chance that no question means to ask about: where in a step a contact falls, which way the axes
of a box point, in which order rounding errors come. So each member starts

* turned about the vertical by an angle of its own: nothing in nature knows x from y, but friction pyramids and axis-aligned
  bounds do;
* later by a share of a step: each free body that moves stands where it was up to one step before, so that impacts fall
  anywhere in a step;
* built with tolerances: each free body stands off its place by up to `TOLERANCE` of its width. Joints stay whole.

Bodies that touch go on touching: of all displacements those are left that open no gap between them, so that bodies slide on
each other by the tolerance, and no more. A gap between bodies that are pressed is another question: they fly across it for a
step without a contact, by p g dt^2 under a push of p weights, however small the gap is. The rounding of a turn is enough for
one, 1e-16 m, so that what touches is set into each other by `PRESSED` of its width, far above rounding and below the tolerance.

Member 0 is the case's own start, with what touches set into each other so. The others are drawn from the member's number alone,
so that every engine and every setting gets the same starts.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from plumbline.harness.case.symmetries import Retelling, turned
from plumbline.harness.scene import Scene, axis_angle, rotate, width
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.touching import touches

TOLERANCE = 1e-4
"""Of a body's width: a tenth of a millimetre at a metre, what a machine shop holds (ISO 2768-1 fine, 0.1..0.15 mm at 1 m)."""
PRESSED = 1e-9
"""Of the thinner width of two bodies that touch: a million times the rounding of a place, and 1e-5 of the tolerance."""


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
    draw, own = np.random.default_rng(number), number == 0
    angle, phase = float(draw.uniform(0.0, 2 * math.pi)), float(draw.uniform())
    joined = {name for joint in scene.joints for name in (joint.parent, joint.child)}
    free = [place for place, body in enumerate(scene.bodies) if body.movable and body.name not in joined]
    off = np.zeros((len(scene.bodies), 3))
    for place, body in enumerate(scene.bodies):
        way = draw.uniform(-1.0, 1.0, 3)
        if place in free and not own:
            size = min((width(placed.shape) for placed in body.collision), default=0.0)
            off[place] = TOLERANCE * (size if math.isfinite(size) else 0.0) * way - phase * dt * np.array(body.v_WB)
    off[free] = _kept_touching(scene, free, off[free])
    places = (np.array([body.p_WB for body in scene.bodies]) + off).tolist()
    bodies = (replace(body, p_WB=tuple(p_WB)) for body, p_WB in zip(scene.bodies, places, strict=True))
    varied = replace(scene, bodies=tuple(bodies))
    retelling = turned(varied, axis_angle((0.0, 0.0, 1.0), angle)) if turn and not own else None
    return Member(varied if retelling is None else retelling.scene, retelling)


def perturbed(scene: Scene, number: int) -> Scene:
    """The scene built with tolerances, and on ground that is level to as much: gravity is tilted by `TOLERANCE` [rad], in a
    direction drawn from the number, so that machines whose joints have to stay whole start otherwise too."""
    angle = float(np.random.default_rng((number, 1)).uniform(0.0, 2 * math.pi))
    tilt = axis_angle((math.cos(angle), math.sin(angle), 0.0), TOLERANCE)
    return replace(member(scene, number, 0.0, turn=False).scene, gravity=rotate(tilt, scene.gravity))


def _kept_touching(scene: Scene, free: list[int], off: Floats) -> Floats:
    """Displacements (n, 3) m of the free bodies, less what opens or closes a gap between bodies that touch: least squares."""
    column = {place: 3 * k for k, place in enumerate(free)}
    touched = [touch for touch in touches(scene) if touch.first in column or touch.second in column]
    if not touched:
        return off
    apart = np.zeros((len(touched), off.size))
    for row, touch in enumerate(touched):
        for place, side in ((touch.first, -1.0), (touch.second, 1.0)):
            if place in column:
                apart[row, column[place] : column[place] + 3] = side * touch.normal
    opened = apart @ off.ravel() + PRESSED * np.array([touch.width for touch in touched])
    kept: Floats = off - np.linalg.lstsq(apart, opened, rcond=None)[0].reshape(off.shape)
    return kept
