"""Where bodies without mass are, and how they move, from what they hang on and the coordinates before them.

An engine that has several joints in one body has no body between them. With X_P the pose of what the first joint hangs on,

    X_k(q) = X_P X_P(0)^-1 exp(S_1 (q_1 - q_1(0))) ... exp(S_k (q_k - q_k(0))) X_k(0),    S_i the line of joint i at time 0.

Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, section 3.2 (products of exponentials).
"""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter.contract import Unsupported
from plumbline.harness.adapter.rotations import matrix
from plumbline.harness.scene import WORLD, Effect, Prismatic, Revolute, Scene, axis_angle, multiply
from plumbline.harness.trajectory import Floats, State


@dataclass(frozen=True, slots=True)
class MasslessChain:
    """Joints one after the other with no mass between them, the last one before a body that has some left out.

    Terms: base: place of the body that the first one hangs on, -1 for the world. joints: places in the scene. bodies: places of
    the bodies without mass, one behind each of them.
    """

    base: int
    joints: tuple[int, ...]
    bodies: tuple[int, ...]


def on_massless(scene: Scene) -> frozenset[str]:
    """The names of the joints that end at a body without mass, which no constraint between free bodies can stand for.

    Raises: Unsupported, where there are any, and the scene leaves joints out.
    """
    massless = {body.name for body in scene.bodies if body.massless}
    if massless and Effect.JOINTS not in scene.effects:
        raise Unsupported(f"body '{min(massless)}' without mass", "it stands between joints, which the scene leaves out")
    return frozenset(joint.name for joint in scene.joints if {joint.parent, joint.child} & massless)


def chains(scene: Scene) -> list[MasslessChain]:
    """All chains of a scene, each from its base on."""
    index = {body.name: k for k, body in enumerate(scene.bodies)} | {WORLD: -1}
    on = {joint.parent: (k, joint.child) for k, joint in enumerate(scene.joints) if scene.bodies[index[joint.child]].massless}
    massless = {body.name for body in scene.bodies if body.massless}
    whole = []
    for k, joint in enumerate(scene.joints):
        if joint.child not in massless or joint.parent in massless:
            continue
        joints, bodies = [k], [index[joint.child]]
        while scene.bodies[bodies[-1]].name in on:
            number, child = on[scene.bodies[bodies[-1]].name]
            joints.append(number)
            bodies.append(index[child])
        whole.append(MasslessChain(index[joint.parent], tuple(joints), tuple(bodies)))
    return whole


def write_between(scene: Scene, chain: MasslessChain, coordinate: Floats, rate: Floats, out: State) -> None:
    """Write the states of the bodies of a chain. Args: coordinate, rate: of its joints; out: with the state of its base."""
    w, v, turned = np.zeros(3), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    R, t = np.eye(3), np.zeros(3)
    if chain.base >= 0:
        base = scene.bodies[chain.base]
        a, b, c, d = base.q_WB
        turned = np.array(multiply(tuple(out.q_WB[chain.base].tolist()), (a, -b, -c, -d)))
        R = matrix(turned)
        t = out.p_WB[chain.base] - R @ np.array(base.p_WB)
        w = out.w_WB[chain.base].copy()
        # Of what moves with the base and is at the world's origin now.
        v = out.v_WB[chain.base] - np.cross(w, out.p_WB[chain.base])
    for number, behind, x, x_rate in zip(chain.joints, chain.bodies, coordinate.tolist(), rate.tolist(), strict=True):
        joint, body = scene.joints[number], scene.bodies[behind]
        assert isinstance(joint, Revolute | Prismatic)
        axis, anchor = R @ np.array(joint.axis_W), R @ np.array(joint.anchor_W) + t
        if isinstance(joint, Revolute):
            turn = axis_angle(joint.axis_W, x - joint.position)
            turned = np.array(multiply(tuple(turned.tolist()), turn))
            R = R @ matrix(np.array(turn))
            t = anchor - R @ np.array(joint.anchor_W)
            w, v = w + x_rate * axis, v - x_rate * np.cross(axis, anchor)
        else:
            t, v = t + (x - joint.position) * axis, v + x_rate * axis
        p = R @ np.array(body.p_WB) + t
        out.p_WB[behind], out.q_WB[behind] = p, multiply(tuple(turned.tolist()), body.q_WB)
        out.v_WB[behind], out.w_WB[behind] = v + np.cross(w, p), w
