"""Checks of what an engine itself tells of joints: coordinates and rates against the poses."""

from typing import Any

import numpy as np

from harness.adapter import Adapter, Feature, Settings, Simulation
from harness.adapter.joints import joints_of
from harness.conformance.check import Finding, NotApplicable, check, judge, near, that
from harness.conformance.runs import FINE, ROUNDING, built, state_of
from harness.conformance.scenes import TURNED, free
from harness.scene import WORLD, Fixed, Prismatic, Revolute, Scene, Spring, Vector3
from harness.trajectory.joint_states import JointStates, joint_states

_NOWHERE: Vector3 = (0.0, 0.0, 0.0)


def _told(simulation: Simulation) -> JointStates:
    """What the engine itself says. Raises: NotApplicable."""
    read: Any = getattr(simulation, "joint_states", None)
    if read is None:
        raise NotApplicable("the engine tells nothing of joints: they are read off the poses of the bodies")
    states: JointStates = read()
    if np.isnan(states.coordinate).all():
        raise NotApplicable("the engine tells no coordinates of joints: they are read off the poses of the bodies")
    return states


def _v(a: object) -> Vector3:
    x, y, z = (float(c) for c in np.asarray(a))
    return (x, y, z)


@check(
    "Are the coordinates and rates that the engine tells those of its bodies?",
    Feature.REVOLUTE | Feature.PRISMATIC | Feature.FIXED | Feature.SPRINGS,
)
def joint_states_agree_with_the_poses(adapter: Adapter, settings: Settings) -> Finding:
    """A wheel that turns more than once, a slide on it, and a hinge whose child carries its parent, all off their zeros."""
    axis, hub, w = np.array([1.0, 2.0, 2.0]) / 3, np.array([0.2, 0.1, 0.0]), 30.0
    spin = w * axis
    places = {"wheel": hub, "carriage": np.array([0.6, 0.1, 0.0]), "flap": np.array([1.0, 0.5, -0.3])}
    bodies = [
        free(name, p=_v(p), q=TURNED, v=_v(np.cross(spin, p - hub)), w=_v(spin)) for name, p in places.items() if name != "flap"
    ]
    bodies.append(free("flap", p=_v(places["flap"]), moments=(0.1, 0.2, 0.25), w=(0.0, 1.0, 0.0)))
    bodies.append(free("post", p=(1.0, 0.0, 0.0)))
    joints = (
        Revolute(name="hub", parent=WORLD, child="wheel", anchor_W=_v(hub), axis_W=_v(axis), position=-0.5),
        Prismatic(
            name="slide",
            parent="wheel",
            child="carriage",
            anchor_W=_v(hub),
            axis_W=(0.6, 0.8, 0.0),
            position=0.3,
            spring=Spring(stiffness=3000.0, rest=0.3),
        ),
        Fixed(name="foot", parent=WORLD, child="post"),
        Revolute(name="hinge", parent="flap", child="post", anchor_W=(1.0, 0.5, -0.3), axis_W=(0.0, 1.0, 0.0), position=0.2),
    )
    scene = Scene(bodies=tuple(bodies), joints=joints, gravity=_NOWHERE)
    with built(adapter, scene, settings.with_dt(FINE)) as simulation:
        started = _told(simulation)
        simulation.step(300)
        states = _told(simulation)
        meant = joint_states(scene, state_of(simulation, scene), near=states.coordinate)
        filled = joints_of(simulation, scene)
    moving = [0, 1, 3]
    because = "the same numbers, by rounding"
    return judge(
        near("coordinates at the start", started.coordinate[moving], (-0.5, 0.3, 0.2), ROUNDING, "the scene's positions"),
        near(
            "rates at the start",
            started.rate[moving],
            (w, 0.0, -1.0),
            ROUNDING * w,
            "the scene's velocities, child over parent",
        ),
        near("coordinates against the poses", states.coordinate[moving], meant.coordinate[moving], ROUNDING, because),
        near("rates against the velocities", states.rate[moving], meant.rate[moving], ROUNDING * w, because),
        that(
            states.coordinate[0] > 2.0 * np.pi,
            f"angle of the wheel: got {states.coordinate[0]:.6g} rad, expected more than a turn after .3 s at 30 rad/s",
        ),
        near("what the harness reads", filled.coordinate[moving], states.coordinate[moving], 0.0, "the engine's own"),
    )
