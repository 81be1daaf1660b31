"""What pybullet's own loaders make of a robot file: `loadURDF` or `loadMJCF`, read back by its queries at zero positions."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plumbline.adapters.bullet.vendor import Port, connected, pybullet_module, silenced
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene.importers.robot import Coordinate, Link
from plumbline.harness.scene.parity.loaded import Loaded, Own, Request, matrix_gap, own_values, read_back, solid_of

_OPEN = 1e9
"""A bound beyond which pybullet means none."""


def load(path: Path, request: Request) -> Loaded:
    """The loaded multibody. Args: request: its way is 'URDF_USE_INERTIA_FROM_FILE' or ''. Raises: Unsupported."""
    if path.suffix.lower() not in (".urdf", ".xml", ".mjcf"):
        raise Unsupported("the file", "pybullet's loaders read URDF, MJCF and SDF")
    if request.way and path.suffix.lower() != ".urdf":
        raise Unsupported("the file", f"{request.way} is for loadURDF alone")
    bullet = pybullet_module()
    port = connected(bullet)
    try:
        with TemporaryDirectory(prefix="plumbline-packages-") as scratch, silenced():
            body, others = _loaded(port, _among_packages(path, request.packages, Path(scratch)), request)
    except (bullet.error, ValueError) as error:
        raise Unsupported("the file", f"pybullet's loader refuses it: {error}") from None
    count = port.call("getNumJoints", body)
    for k in range(count):
        port.call("resetJointState", body, k, 0.0)
    base_name = port.call("getBodyInfo", body)[0].decode()
    names = {-1: f"{base_name} (base)"} | {k: port.call("getJointInfo", body, k)[12].decode() for k in range(count)}
    endless = _continuous(path) if path.suffix.lower() == ".urdf" else frozenset()
    links = [_base(port, body, names[-1], request.root, path), *(_link(port, body, k, names, endless) for k in range(count))]
    robot = read_back(f"pybullet {'with ' + request.way if request.way else 'by default'}", links)
    movable = [k for k in range(count) if port.call("getJointInfo", body, k)[2] != bullet.JOINT_FIXED]
    order = [port.call("getJointInfo", body, k)[1].decode() for k in movable]

    def matrix(q: dict[str, float]) -> Any:
        try:
            M = np.array(port.call("calculateMassMatrix", body, [q[name] for name in order]))
        except (bullet.error, SystemError):
            return None
        places = [order.index(name) for name in q]
        return M[np.ix_(places, places)] if M.shape == (len(order), len(order)) else None

    own = _own(port, body, count)
    if path.suffix.lower() == ".urdf":
        scalar = [
            k for k in movable if port.call("getJointInfo", body, k)[2] in (bullet.JOINT_REVOLUTE, bullet.JOINT_PRISMATIC)
        ]
        own += (*_motors(port, body, scalar), *_body_damping(port, body, scalar))
    notes = (f"{others} more bodies that move were made of the file, and are not compared",) if others else ()
    return Loaded(robot=robot, matrix_gap=matrix_gap(robot, matrix), notes=notes, own=own)


_OWN = (
    (1, "friction", "1"),
    (7, "torsional friction", "m"),
    (6, "rolling friction", "m"),
    (5, "restitution", "1"),
    (11, "collision margin", "m"),
)
"""The places of `getDynamicsInfo` at which a shape's own numbers stand."""


def _own(port: Port, body: int, count: int) -> tuple[Own, ...]:
    """What the links with shapes that touch are given; each is told for all its shapes together."""
    touching = [k for k in range(-1, count) if port.call("getCollisionShapeData", body, k)]
    rows = [port.call("getDynamicsInfo", body, k) for k in touching]
    return tuple(own for index, quantity, unit in _OWN for own in own_values(quantity, (each[index] for each in rows), unit))


_SWIFT, _SLOW = 90.0, 1e-3
"""Rates [rad/s, m/s]: that a motor on a joint cannot stop in a step, below the 100 at which pybullet cuts; and such that what
goes with their squares does not count."""


def _motors(port: Port, body: int, scalar: list[int]) -> Iterator[Own]:
    """The motor that pybullet puts on each hinge and slide, which asks for no velocity: what it bears in a step, measured."""
    kinds = {port.bullet.JOINT_REVOLUTE: "N m s", port.bullet.JOINT_PRISMATIC: "N s"}
    impulses: dict[str, list[float]] = {unit: [] for unit in kinds.values()}
    for k in scalar:
        rate, torque, step = _stepped(port, body, k, _SWIFT, scalar)
        if abs(rate) > _SLOW:  # else it was stopped by less than the motor bears
            impulses[kinds[port.call("getJointInfo", body, k)[2]]].append(float(f"{abs(torque) * step:.4g}"))
    for unit, values in impulses.items():
        yield from own_values("motor that holds joints still, in a step by up to", values, unit)


def _body_damping(port: Port, body: int, scalar: list[int]) -> tuple[Own, ...]:
    """The damping of bodies that move, as measured on hinges and slides without their motors and dampers."""
    for k in scalar:
        port.call("changeDynamics", body, k, jointDamping=0.0)
        port.call("setJointMotorControl2", body, k, port.bullet.VELOCITY_CONTROL, force=0.0)
    shares = []
    for k in scalar:
        joint = port.call("getJointInfo", body, k)
        if joint[8] > joint[9] or joint[8] < 0.0 < joint[9]:  # no bound acts at 0
            rate, _, step = _stepped(port, body, k, _SLOW, scalar)
            shares.append(float(f"{(1 - rate / _SLOW) / step:.2g}"))
    return own_values("damping of moving bodies", shares, "1/s")


def _stepped(port: Port, body: int, k: int, rate: float, scalar: list[int]) -> tuple[float, float, float]:
    """The rate of a joint and its motor's torque [N m or N] a step [s] after it alone had this rate, all at zero positions."""
    for joint in scalar:
        port.call("resetJointState", body, joint, 0.0, rate if joint == k else 0.0)
    port.call("setGravity", 0.0, 0.0, 0.0)
    port.call("stepSimulation")
    state = port.call("getJointState", body, k)
    return state[1], state[3], port.call("getPhysicsEngineParameters")["fixedTimeStep"]


def _loaded(port: Port, path: Path, request: Request) -> tuple[int, int]:
    """The body of the file with the most joints, and how many others can move."""
    # pybullet keeps the text of files by their paths, as long as the process lives: a rewritten file would be the old one.
    port.call("setPhysicsEngineParameter", enableFileCaching=0)
    flags = getattr(port.bullet, request.way) if request.way else 0
    if path.suffix.lower() == ".urdf":
        return port.call("loadURDF", str(path), useFixedBase=request.root == "fixed", flags=flags), 0
    bodies = port.call("loadMJCF", str(path), flags=flags)
    if not bodies:
        raise Unsupported("the file", "pybullet's loader makes no body of it")
    moving = [b for b in bodies if port.call("getNumJoints", b) or port.call("getDynamicsInfo", b, -1)[0] > 0]
    body = max(moving or bodies, key=lambda b: port.call("getNumJoints", b))
    return body, max(0, len(moving) - 1)


def _among_packages(path: Path, packages: Mapping[str, Path], scratch: Path) -> Path:
    """The file with the packages beside its folder, where pybullet looks for them, as links."""
    if not packages:
        return path
    home = scratch / "plumbline-home"
    home.symlink_to(path.parent, target_is_directory=True)
    for name, folder in packages.items():
        (scratch / name).symlink_to(folder, target_is_directory=True)
    return home / path.name


def _base(port: Port, body: int, name: str, root: str, path: Path) -> Link:
    """The root; one that is free is put with its frame at W's origin. What is fixed to the world does not count."""
    dynamics = port.call("getDynamicsInfo", body, -1)
    mass, moments, p, q = float(dynamics[0]), dynamics[2], dynamics[3], dynamics[4]
    free = root == "floating" if path.suffix.lower() == ".urdf" else mass > 0
    if not free:
        return Link(name=name, parent=None)
    port.call("resetBasePositionAndOrientation", body, p, q)
    R = Rotation.from_quat(q).as_matrix()
    solid = solid_of(mass, np.array(p), R @ np.diag(moments) @ R.T)
    return Link(name=name, parent=None, coordinates=(Coordinate(name=f"{name}.root", kind="free"),), solid=solid)


def _continuous(path: Path) -> frozenset[str]:
    """The continuous joints of a URDF: the queries tell the limits of their <limit>, which are not applied to them."""
    from defusedxml.ElementTree import parse

    joints = parse(path).getroot().iter("joint")
    return frozenset(joint.get("name", "") for joint in joints if joint.get("type") == "continuous")


def _link(port: Port, body: int, k: int, names: dict[int, str], endless: frozenset[str]) -> Link:
    bullet = port.bullet
    joint, dynamics = port.call("getJointInfo", body, k), port.call("getDynamicsInfo", body, k)
    state = port.call("getLinkState", body, k, computeForwardKinematics=True)
    R = Rotation.from_quat(state[1]).as_matrix()
    coordinates: tuple[Coordinate, ...] = ()
    if joint[2] == bullet.JOINT_PLANAR:
        raise Unsupported(f"joint '{joint[1].decode()}'", "pybullet tells no axes of a planar joint")
    if joint[2] != bullet.JOINT_FIXED:
        bounded = joint[1].decode() not in endless and joint[8] <= joint[9] and max(abs(joint[8]), abs(joint[9])) < _OPEN
        kinds = {bullet.JOINT_PRISMATIC: "prismatic", bullet.JOINT_SPHERICAL: "ball"}
        coordinates = (
            Coordinate(
                name=joint[1].decode(),
                kind=kinds.get(joint[2], "revolute"),  # type: ignore[arg-type]
                axis=R @ np.array(joint[13]),  # the axis is told in the inertial frame of the child
                anchor=np.array(state[4]),
                lower=float(joint[8]) if bounded else None,
                upper=float(joint[9]) if bounded else None,
                damping=float(joint[6]),
                friction_loss=float(joint[7]),
                effort=float(joint[10]) if 0 < joint[10] < _OPEN else None,
                speed=float(joint[11]) if 0 < joint[11] < _OPEN else None,
            ),
        )
    solid = solid_of(float(dynamics[0]), np.array(state[0]), R @ np.diag(dynamics[2]) @ R.T)
    return Link(name=names[k], parent=names[joint[16]], coordinates=coordinates, solid=solid)
