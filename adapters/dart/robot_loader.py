"""What DART's own loader makes of a robot file: `DartLoader`, read back from the skeleton at zero positions."""

from pathlib import Path
from typing import Any

import numpy as np

from adapters.dart.vendor import load as dart_module
from adapters.dart.vendor import overheard
from harness.adapter import Unsupported
from harness.scene.parity.facts import FIXED, JointFacts
from harness.scene.parity.loaded import Loaded, LoadedLink, gathered, matrix_gap

__all__ = ["load"]

_KINDS = {"RevoluteJoint": "revolute", "PrismaticJoint": "prismatic", "BallJoint": "ball", "FreeJoint": "free"}


def load(path: Path) -> Loaded:
    """The loaded skeleton, its root fixed. Raises: Unsupported, Unavailable."""
    dart = dart_module()
    if path.suffix.lower() != ".urdf":
        raise Unsupported("MJCF", "DartLoader reads URDF alone")
    heard: list[str] = []
    with overheard(heard):
        loader = dart.utils.DartLoader()
        options = dart.utils.DartLoaderOptions()
        options.mDefaultRootJointType = dart.utils.DartLoaderRootJointType.FIXED
        loader.setOptions(options)
        skeleton = loader.parseSkeleton(str(path))
    if skeleton is None:
        raise Unsupported("the file", f"DartLoader refuses it: {' '.join(heard)[:300]}")
    skeleton.setPositions(np.zeros(skeleton.getNumDofs()))
    links, laws = [], []
    for k in range(skeleton.getNumBodyNodes()):
        node = skeleton.getBodyNode(k)
        joint = node.getParentJoint()
        if "MIMIC" in str(joint.getActuatorType()).upper():
            laws.append(("mimic", joint.getName()))
        links.append(_link(node, joint))
    facts = gathered("DART", links, tuple(laws))
    places = {
        skeleton.getJoint(k).getName(): int(skeleton.getJoint(k).getIndexInSkeleton(0))
        for k in range(skeleton.getNumJoints())
        if skeleton.getJoint(k).getNumDofs() == 1
    }

    def matrix(q: dict[str, float]) -> Any:
        positions = np.zeros(skeleton.getNumDofs())
        for name, value in q.items():
            positions[places[name]] = value
        skeleton.setPositions(positions)
        order = [places[name] for name in q]
        return np.array(skeleton.getMassMatrix())[np.ix_(order, order)]

    return Loaded(facts=facts, matrix_gap=matrix_gap(facts, matrix))


def _link(node: Any, joint: Any) -> LoadedLink:
    X, parent = node.getWorldTransform(), node.getParentBodyNode()
    R, inertia = np.array(X.rotation()), node.getInertia()
    return LoadedLink(
        name=node.getName(),
        parent=None if parent is None else parent.getName(),
        joints=() if joint.getNumDofs() == 0 else (_joint(joint, X),),
        mass=float(inertia.getMass()),
        centre=R @ np.array(inertia.getLocalCOM()) + np.array(X.translation()),
        inertia=R @ np.array(inertia.getMoment()) @ R.T,
    )


def _joint(joint: Any, X: Any) -> JointFacts:
    kind = _KINDS.get(joint.getType())
    if kind is None:
        raise Unsupported(f"joint '{joint.getName()}'", f"DartLoader made it a {joint.getType()}")
    scalar = kind in ("revolute", "prismatic")
    within = joint.getTransformFromChildBodyNode()
    R = np.array(X.rotation())
    axis = R @ np.array(within.rotation()) @ np.array(joint.getAxis()) if scalar else np.array([1.0, 0.0, 0.0])
    lower, upper = float(joint.getPositionLowerLimit(0)), float(joint.getPositionUpperLimit(0))
    effort, speed = float(joint.getForceUpperLimit(0)), float(joint.getVelocityUpperLimit(0))
    return JointFacts(
        name=joint.getName(),
        kind=kind,  # type: ignore[arg-type]
        parent=FIXED,
        axis=axis,
        anchor=R @ np.array(within.translation()) + np.array(X.translation()),
        lower=lower if scalar and np.isfinite(lower) else None,
        upper=upper if scalar and np.isfinite(upper) else None,
        damping=float(joint.getDampingCoefficient(0)),
        stiffness=float(joint.getSpringStiffness(0)),
        friction_loss=float(joint.getCoulombFriction(0)),
        effort=effort if np.isfinite(effort) and effort > 0 else None,
        speed=speed if np.isfinite(speed) and speed > 0 else None,
    )
