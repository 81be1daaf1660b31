"""The planted faults of joints as an engine tells them: coordinates, rates and reactions that are not those of its bodies."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from harness.adapter import Adapter
from harness.conformance.faults.plant import Wrapped, wrapped
from harness.trajectory.joint_states import JointStates

__all__ = ["misread_joints", "on_the_parent", "reversed_rates", "within_a_turn"]


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
