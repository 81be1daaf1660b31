"""What pybullet's own loaders make of a robot file: `loadURDF` or `loadMJCF`, read back by its queries at zero positions."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from adapters.bullet.vendor import Port, connected, pybullet_module, silenced
from harness.adapter import Unsupported
from harness.scene.parity.facts import FIXED, JointFacts
from harness.scene.parity.loaded import Loaded, LoadedLink, gathered, matrix_gap

__all__ = ["load"]

_OPEN = 1e9
"""A bound beyond which pybullet means none."""


def load(path: Path, variant: str) -> Loaded:
    """The loaded multibody, its root fixed. Args: variant: 'URDF_USE_INERTIA_FROM_FILE' or ''. Raises: Unsupported."""
    bullet = pybullet_module()
    port = connected(bullet)
    flags = getattr(bullet, variant) if variant else 0
    try:
        with silenced():
            if path.suffix.lower() == ".urdf":
                body = port.call("loadURDF", str(path), useFixedBase=True, flags=flags)
            else:
                bodies = port.call("loadMJCF", str(path), flags=flags)
                body = max(bodies, key=lambda b: port.call("getNumJoints", b))
    except (bullet.error, ValueError) as error:
        raise Unsupported("the file", f"pybullet's loader refuses it: {error}") from None
    count = port.call("getNumJoints", body)
    for k in range(count):
        port.call("resetJointState", body, k, 0.0)
    base_name = port.call("getBodyInfo", body)[0].decode()
    names = {-1: f"{base_name} (base)"} | {k: port.call("getJointInfo", body, k)[12].decode() for k in range(count)}
    base = LoadedLink(
        name=names[-1], parent=None, joints=(), mass=0.0, centre=np.zeros(3), inertia=np.zeros((3, 3))
    )  # what is fixed to the world does not count
    endless = _continuous(path)
    links = [base, *(_link(port, body, k, names, endless) for k in range(count))]
    facts = gathered(f"pybullet {'with ' + variant if variant else 'by default'}", links)
    movable = [k for k in range(count) if port.call("getJointInfo", body, k)[2] != bullet.JOINT_FIXED]
    order = [port.call("getJointInfo", body, k)[1].decode() for k in movable]

    def matrix(q: dict[str, float]) -> Any:
        try:
            M = np.array(port.call("calculateMassMatrix", body, [q[name] for name in order]))
        except (bullet.error, SystemError):
            return None
        places = [order.index(name) for name in q]
        return M[np.ix_(places, places)] if M.shape == (len(order), len(order)) else None

    return Loaded(facts=facts, matrix_gap=matrix_gap(facts, matrix))


def _continuous(path: Path) -> frozenset[str]:
    """The continuous joints of a URDF: the queries tell the limits of their <limit>, which are not applied to them."""
    from defusedxml.ElementTree import parse

    joints = parse(path).getroot().iter("joint")
    return frozenset(joint.get("name", "") for joint in joints if joint.get("type") == "continuous")


def _link(port: Port, body: int, k: int, names: dict[int, str], endless: frozenset[str]) -> LoadedLink:
    bullet = port.bullet
    told, dynamics = port.call("getJointInfo", body, k), port.call("getDynamicsInfo", body, k)
    state = port.call("getLinkState", body, k, computeForwardKinematics=True)
    R = Rotation.from_quat(state[1]).as_matrix()
    joints: tuple[JointFacts, ...] = ()
    if told[2] != bullet.JOINT_FIXED:
        bounded = told[1].decode() not in endless and told[8] <= told[9] and max(abs(told[8]), abs(told[9])) < _OPEN
        kinds = {bullet.JOINT_PRISMATIC: "prismatic", bullet.JOINT_SPHERICAL: "ball"}
        joints = (
            JointFacts(
                name=told[1].decode(),
                kind=kinds.get(told[2], "revolute"),  # type: ignore[arg-type]
                parent=FIXED,
                axis=R @ np.array(told[13]),  # the axis is told in the inertial frame of the child
                anchor=np.array(state[4]),
                lower=float(told[8]) if bounded else None,
                upper=float(told[9]) if bounded else None,
                damping=float(told[6]),
                friction_loss=float(told[7]),
                effort=float(told[10]) if 0 < told[10] < _OPEN else None,
                speed=float(told[11]) if 0 < told[11] < _OPEN else None,
            ),
        )
    return LoadedLink(
        name=names[k],
        parent=names[told[16]],
        joints=joints,
        mass=float(dynamics[0]),
        centre=np.array(state[0]),
        inertia=R @ np.diag(dynamics[2]) @ R.T,
    )
