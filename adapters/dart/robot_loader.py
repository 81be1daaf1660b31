"""What DART's own loaders make of a robot file: `DartLoader` or `MjcfParser`, read back from skeletons at zero positions."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.adapters.dart.vendor import load as dart_module
from plumbline.adapters.dart.vendor import overheard
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene.importers.robot import Coordinate, Link, Tie
from plumbline.harness.scene.parity.loaded import Loaded, Own, Request, matrix_gap, own_values, read_back, solid_of

_KINDS = {"RevoluteJoint": "revolute", "PrismaticJoint": "prismatic", "BallJoint": "ball", "FreeJoint": "free"}
_SIDES = ("x", "y", "angle")
"""The coordinates of a planar joint, as they are called here."""


def load(path: Path, request: Request) -> Loaded:
    """The loaded skeletons. Raises: Unsupported, Unavailable."""
    dart = dart_module()
    kind = path.suffix.lower()
    if kind not in (".urdf", ".xml", ".mjcf"):
        raise Unsupported("the file", "DART's loaders of URDF and MJCF alone are compared here; expected .urdf, .xml or .mjcf")
    heard: list[str] = []
    with overheard(heard):
        skeletons = _of_urdf(dart, path, request) if kind == ".urdf" else _of_mjcf(dart, path)
    if not skeletons:
        reader = "DartLoader" if kind == ".urdf" else "MjcfParser"
        raise Unsupported("the file", f"{reader} refuses it: {' '.join(heard)[:300]}")
    links = []
    for skeleton in skeletons:
        skeleton.setPositions(np.zeros(skeleton.getNumDofs()))
        for k in range(skeleton.getNumBodyNodes()):
            node = skeleton.getBodyNode(k)
            links.append(_link(node, node.getParentJoint()))
    robot = read_back("DART", links)
    skeleton = max(skeletons, key=lambda candidate: candidate.getNumDofs())
    own = tuple(_own(skeletons))
    if sum(candidate.getNumDofs() > 0 for candidate in skeletons) > 1:
        return Loaded(robot=robot, own=own)
    places: dict[str, int] = {}
    for joint in map(skeleton.getJoint, range(skeleton.getNumJoints())):
        names = [f"{joint.getName()}.{side}" for side in _SIDES] if joint.getType() == "PlanarJoint" else [joint.getName()]
        if len(names) == joint.getNumDofs():
            places |= {name: int(joint.getIndexInSkeleton(k)) for k, name in enumerate(names)}

    def matrix(q: dict[str, float]) -> Any:
        positions = np.zeros(skeleton.getNumDofs())
        for name, value in q.items():
            positions[places[name]] = value
        skeleton.setPositions(positions)
        order = [places[name] for name in q]
        return np.array(skeleton.getMassMatrix())[np.ix_(order, order)]

    return Loaded(robot=robot, matrix_gap=matrix_gap(robot, matrix), own=own)


def _own(skeletons: list[Any]) -> Iterator[Own]:
    """What the shapes that touch are given."""
    nodes = [skeleton.getBodyNode(k) for skeleton in skeletons for k in range(skeleton.getNumBodyNodes())]
    shapes = [node.getShapeNode(k).getDynamicsAspect() for node in nodes for k in range(node.getNumShapeNodes())]
    aspects = [aspect for aspect in shapes if aspect is not None]
    yield from own_values("friction", (aspect.getFrictionCoeff() for aspect in aspects), "1")
    yield from own_values("restitution", (aspect.getRestitutionCoeff() for aspect in aspects), "1")


def _of_urdf(dart: Any, path: Path, request: Request) -> list[Any]:
    loader, options, roots = dart.utils.DartLoader(), dart.utils.DartLoaderOptions(), dart.utils.DartLoaderRootJointType
    options.mDefaultRootJointType = roots.FLOATING if request.root == "floating" else roots.FIXED
    loader.setOptions(options)
    for name, folder in request.packages.items():
        loader.addPackageDirectory(name, str(folder))
    skeleton = loader.parseSkeleton(str(path))
    return [] if skeleton is None else [skeleton]


def _of_mjcf(dart: Any, path: Path) -> list[Any]:
    """The skeletons of the world but for those of the world's own geoms and sites."""
    world = dart.utils.MjcfParser.readWorld(str(path))
    made = [] if world is None else [world.getSkeleton(k) for k in range(world.getNumSkeletons())]
    return [skeleton for skeleton in made if not skeleton.getName().startswith("__")]


def _link(node: Any, joint: Any) -> Link:
    X, parent = node.getWorldTransform(), node.getParentBodyNode()
    R, inertia = np.array(X.rotation()), node.getInertia()
    centre = R @ np.array(inertia.getLocalCOM()) + np.array(X.translation())
    return Link(
        name=node.getName(),
        parent=None if parent is None else parent.getName(),
        coordinates=()
        if joint.getNumDofs() == 0
        else _planar(joint, X)
        if joint.getType() == "PlanarJoint"
        else (_joint(joint, X),),
        solid=solid_of(float(inertia.getMass()), centre, R @ np.array(inertia.getMoment()) @ R.T),
    )


def _planar(joint: Any, X: Any) -> tuple[Coordinate, ...]:
    """Two slides and a hinge, which share the joint's damping one by one."""
    within = joint.getTransformFromChildBodyNode()
    R, anchor = np.array(X.rotation()) @ np.array(within.rotation()), np.array(X.rotation()) @ np.array(within.translation())
    along = (joint.getTranslationalAxis1(), joint.getTranslationalAxis2(), joint.getRotationalAxis())
    return tuple(
        Coordinate(
            name=f"{joint.getName()}.{side}",
            kind="revolute" if side == "angle" else "prismatic",
            axis=R @ np.array(axis).ravel(),
            anchor=anchor + np.array(X.translation()),
            damping=float(joint.getDampingCoefficient(k)),
            stiffness=float(joint.getSpringStiffness(k)),
            friction_loss=float(joint.getCoulombFriction(k)),
        )
        for k, (side, axis) in enumerate(zip(_SIDES, along, strict=True))
    )


def _joint(joint: Any, X: Any) -> Coordinate:
    kind = _KINDS.get(joint.getType())
    if kind is None:
        raise Unsupported(f"joint '{joint.getName()}'", f"DartLoader made it a {joint.getType()}")
    scalar = kind in ("revolute", "prismatic")
    within = joint.getTransformFromChildBodyNode()
    R = np.array(X.rotation())
    axis = R @ np.array(within.rotation()) @ np.array(joint.getAxis()) if scalar else np.array([1.0, 0.0, 0.0])
    lower, upper = float(joint.getPositionLowerLimit(0)), float(joint.getPositionUpperLimit(0))
    scalar_limits = scalar and joint.areLimitsEnforced()
    effort, speed = float(joint.getForceUpperLimit(0)), float(joint.getVelocityUpperLimit(0))
    return Coordinate(
        name=joint.getName(),
        kind=kind,  # type: ignore[arg-type]
        axis=axis,
        anchor=R @ np.array(within.translation()) + np.array(X.translation()),
        lower=lower if scalar_limits and np.isfinite(lower) else None,
        upper=upper if scalar_limits and np.isfinite(upper) else None,
        damping=float(joint.getDampingCoefficient(0)),
        stiffness=float(joint.getSpringStiffness(0)),
        rest=float(joint.getRestPosition(0)) if scalar and joint.getSpringStiffness(0) > 0 else 0.0,
        friction_loss=float(joint.getCoulombFriction(0)),
        effort=effort if np.isfinite(effort) and effort > 0 else None,
        speed=speed if np.isfinite(speed) and speed > 0 else None,
        # dartpy does not tell what it follows
        tie=Tie(joint="", ratio=1.0) if "MIMIC" in str(joint.getActuatorType()).upper() else None,
    )
