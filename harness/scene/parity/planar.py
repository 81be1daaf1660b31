"""Planar joints: two slides and a hinge across them, of which the directions of the slides are anybody's choice."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from plumbline.harness.scene.parity.facts import JointFacts, RobotFacts

_ACROSS = 1e-9
"""How far from a right angle axes may be that are written down as being at one."""
Plane = tuple[JointFacts, JointFacts, JointFacts]


def planes(robot: RobotFacts) -> Iterator[Plane]:
    """Two slides and a hinge, each on the one before, at right angles, along which both slides are resisted alike."""
    for angle in robot.joints:
        above = {joint.name: joint for joint in robot.joints}
        y = above.get(angle.parent)
        x = None if y is None else above.get(y.parent)
        if x is None or y is None or [x.kind, y.kind, angle.kind] != ["prismatic", "prismatic", "revolute"]:
            continue
        axes = np.array([x.axis, y.axis, angle.axis])
        if np.abs(axes @ axes.T - np.eye(3)).max() <= _ACROSS and _resisted(x) == _resisted(y):
            yield x, y, angle


def _resisted(slide: JointFacts) -> tuple[object, ...]:
    """What acts along a slide; a bound or a drive is of its own direction."""
    own = slide.name if (slide.lower, slide.upper, slide.drive, slide.friction_loss) != (None, None, None, 0.0) else ""
    return slide.damping, slide.stiffness, slide.rest, slide.armature, own


def turned_alike(a: RobotFacts, b: RobotFacts) -> RobotFacts:
    """B with its planar joints' slides along A's directions, where both slide in one plane: that is the same joint."""
    own = {tuple(joint.name for joint in plane): plane for plane in planes(b)}
    turned: dict[str, JointFacts] = {}
    for plane in planes(a):
        other = own.get(tuple(joint.name for joint in plane))
        if other is not None and max(abs(plane[2].axis @ slide.axis) for slide in other[:2]) <= _ACROSS:
            turned |= {joint.name: replace(slide, axis=joint.axis) for joint, slide in zip(plane[:2], other[:2], strict=True)}
    return replace(b, joints=tuple(turned.get(joint.name, joint) for joint in b.joints))
