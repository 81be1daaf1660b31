"""The joints of a running simulation: coordinates, rates and reactions, by the engine where it tells them, else by poses.

An engine that tells wrenches on bodies tells reactions: about the anchor on the child, at the instant for which it means them.
"""

from typing import Any

import numpy as np

from plumbline.harness.adapter.simulation import Simulation
from plumbline.harness.scene import Joint, Scene
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.joint_states import JointStates, joint_states
from plumbline.harness.trajectory.kinematics import product, rotate, rotate_back


def joints_of(simulation: Simulation, scene: Scene, near: Floats | None = None) -> JointStates:
    """Coordinates [rad or m], rates and reactions of the scene's joints at this instant.

    Coordinates and rates are known on every engine: what it does not tell itself follows from the poses and velocities of the
    bodies. Reactions are NaN where the engine does not tell them.

    Args: near (j,): earlier coordinates, which tell the turn of an angle that is read off poses; None: the first one.
    """
    state = State.empty(len(scene.bodies))
    simulation.state(state)
    meant = joint_states(scene, state, near)
    own: Any = getattr(simulation, "joint_states", None)
    if own is None:
        return meant
    states: JointStates = own()
    return JointStates(
        np.where(np.isnan(states.coordinate), meant.coordinate, states.coordinate),
        np.where(np.isnan(states.rate), meant.rate, states.rate),
        states.reaction,
    )


def turned_back(state: State, time: float) -> State:
    """The state `time` [s] ago, for bodies that kept the velocities which they have: where a semi-implicit step began."""
    angle = time * np.linalg.norm(state.w_WB, axis=1, keepdims=True)
    # np.sinc(x) is sin(pi x)/(pi x), also where a body does not turn.
    turn = np.concatenate([np.cos(angle / 2), -np.sinc(angle / (2 * np.pi)) * state.w_WB * time / 2], axis=1)
    return State(state.p_WB - time * state.v_WB, product(turn, state.q_WB), state.v_WB, state.w_WB)


def about_the_anchor(scene: Scene, joint: Joint, state: State, on: int, wrench_W: Floats) -> Floats:
    """The reaction (6,) of a joint as `harness.trajectory.joint_states` has it.

    Args:
        on: the place of the body that a joint's wrench acts on, child or parent. wrench_W (6,): force [N] and torque [N m] in W
        about that body's centre of mass, in this state.
    """
    child = scene.index(joint.child)
    body = scene.bodies[child]
    start = np.asarray(getattr(joint, "child_anchor_W", getattr(joint, "anchor_W", body.p_WB)))
    arm_B = rotate_back(np.asarray(body.q_WB)[None], (start - np.asarray(body.p_WB))[None])
    anchor = state.p_WB[child] + rotate(state.q_WB[child][None], arm_B)[0]
    force, torque = wrench_W[:3], wrench_W[3:]
    reaction = np.concatenate((force, torque + np.cross(state.p_WB[on] - anchor, force)))
    return reaction if on == child else -reaction
