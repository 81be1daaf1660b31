"""The joints of a running simulation: coordinates, rates and reactions, by the engine where it tells them, else by poses."""

from typing import Any

import numpy as np

from plumbline.harness.adapter.simulation import Simulation
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.joint_states import JointStates, joint_states


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
