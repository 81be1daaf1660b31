"""The planted faults of joints as an engine tells them: coordinates, rates and reactions that are not those of its bodies."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from harness.adapter import Adapter
from harness.conformance.faults.plant import Wrapped, wrapped
from harness.scene import Scene
from harness.trajectory import Floats, State
from harness.trajectory.joint_states import JointStates
from harness.trajectory.kinematics import rotate, rotate_back

__all__ = [
    "about_the_centre",
    "in_the_child",
    "misread_joints",
    "misread_reactions",
    "on_the_parent",
    "reversed_rates",
    "weightless",
    "within_a_turn",
]


def misread_joints(change: Callable[[JointStates], JointStates]) -> Callable[[Adapter], Adapter]:
    """What the engine tells of joints is changed."""

    class Misread(Wrapped):
        def joint_states(self) -> JointStates:
            """As inside, changed."""
            inner: Any = self.inner
            return change(inner.joint_states())

    return wrapped(Misread)


def reversed_rates(states: JointStates) -> JointStates:
    """Rates of the parent over the child."""
    return replace(states, rate=-states.rate)


def within_a_turn(states: JointStates) -> JointStates:
    """Angles lose their full turns."""
    return replace(states, coordinate=(states.coordinate + np.pi) % (2.0 * np.pi) - np.pi)


def on_the_parent(states: JointStates) -> JointStates:
    """Reactions on the parent instead of the child."""
    return replace(states, reaction=-states.reaction)


def misread_reactions(change: Callable[[Floats, Scene, State], Floats]) -> Callable[[Adapter], Adapter]:
    """The reactions (j, 6) that the engine tells are changed, by the scene and its present state."""

    class Misread(Wrapped):
        def joint_states(self) -> JointStates:
            """As inside, the reactions changed."""
            inner: Any = self.inner
            states: JointStates = inner.joint_states()
            return replace(states, reaction=change(states.reaction, self.scene, self.now()))

    return wrapped(Misread)


def in_the_child(reaction: Floats, scene: Scene, state: State) -> Floats:
    """Reactions in the frame of the child instead of W."""
    turn = state.q_WB[[scene.index(joint.child) for joint in scene.joints]]
    return np.hstack((rotate_back(turn, reaction[:, :3]), rotate_back(turn, reaction[:, 3:])))


def about_the_centre(reaction: Floats, scene: Scene, state: State) -> Floats:
    """Torques about the child's centre of mass instead of its anchor."""
    told = reaction.copy()
    for k, joint in enumerate(scene.joints):
        place = scene.index(joint.child)
        body = scene.bodies[place]
        arm = np.asarray(getattr(joint, "anchor_W", body.p_WB)) - np.asarray(body.p_WB)
        lever = rotate(state.q_WB[place], rotate_back(np.asarray(body.q_WB), arm))
        told[k, 3:] += np.cross(lever, reaction[k, :3])
    return told


def weightless(reaction: Floats, scene: Scene, state: State) -> Floats:  # noqa: ARG001  all changes are told the state
    """Reactions without the weight of the child."""
    told = reaction.copy()
    for k, joint in enumerate(scene.joints):
        told[k, :3] += scene.bodies[scene.index(joint.child)].mass * np.asarray(scene.gravity)
    return told
