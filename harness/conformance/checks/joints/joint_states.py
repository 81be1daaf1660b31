"""Checks of what an engine itself tells of joints: coordinates and rates against poses, forces and torques against statics."""

from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation
from plumbline.harness.adapter.joints import joints_of
from plumbline.harness.conformance.check import CheckResult, Compared, NotApplicable, check, judge, near, that
from plumbline.harness.conformance.room import FINE, ROUNDING, built, state_of
from plumbline.harness.conformance.scenes import TURNED, G, floor, free, ground
from plumbline.harness.scene import WORLD, Ball, Fixed, PlacedShape, Prismatic, Revolute, Scene, Sphere, Spring, Vector3
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.joint_states import JointStates, joint_states

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
def joint_states_agree_with_the_poses(adapter: Adapter, settings: Settings) -> CheckResult:
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


_SETTLED = 1e-3
"""Share of the weights that what rests may still move by, after so many steps."""


def _reactions(adapter: Adapter, scene: Scene, settings: Settings, steps: int) -> Floats:
    """The reactions (j, 6) after some steps, to an engine that was told beforehand that it will be asked.

    Raises: NotApplicable.
    """
    with built(adapter, scene, settings) as simulation:
        read: Any = getattr(simulation, "joint_states", None)
        if read is None:
            raise NotApplicable("the engine tells nothing of joints: they are read off the poses of the bodies")
        read()
        simulation.step(steps)
        reaction: Floats = read().reaction
    if np.isnan(reaction).all():
        raise NotApplicable("the engine tells no reactions of joints")
    return reaction


@check(
    "Are the forces and torques that the engine tells of joints those that hold up what hangs on them?",
    Feature.REVOLUTE | Feature.FIXED | Feature.SPRINGS,
)
def joint_reactions_bear_what_hangs(adapter: Adapter, settings: Settings) -> CheckResult:
    """A bracket welded to the wall with a boom on a hinge, held level by its spring: weights and their moments, at rest."""
    bracket, boom = free("bracket", mass=2.0, p=(0.5, 0.0, 1.0)), free("boom", mass=1.0, p=(1.4, 0.2, 1.0), q=TURNED)
    moment = 1.0 * G * 0.4
    joints = (
        Fixed(name="weld", parent=WORLD, child="bracket"),
        Revolute(
            name="hinge",
            parent="bracket",
            child="boom",
            anchor_W=(1.0, 0.0, 1.0),
            axis_W=(0.0, 1.0, 0.0),
            # About y a weight at +x turns positively: the spring has to hold against it.
            spring=Spring(stiffness=1000.0, damping=50.0, rest=-moment / 1000.0),
        ),
    )
    told = _reactions(adapter, Scene(bodies=(bracket, boom), joints=joints), settings.with_dt(FINE), 10)
    weld = (0.0, 0.0, 3.0 * G, 0.2 * 1.0 * G, -0.9 * 1.0 * G, 0.0)
    hinge = (0.0, 0.0, 1.0 * G, 0.2 * 1.0 * G, -moment, 0.0)
    return judge(
        near("force and torque of the weld on the bracket [N, N m]", told[0], weld, _SETTLED * G, "weight times arm"),
        near("force and torque of the hinge on the boom [N, N m]", told[1], hinge, _SETTLED * G, "weight times arm"),
    )


@check(
    "Is what dry friction bears in what the engine tells of a joint, whichever of its bodies hangs on the other?",
    Feature.REVOLUTE | Feature.FIXED | Feature.FRICTION_LOSS,
)
def joint_reactions_bear_what_friction_holds(adapter: Adapter, settings: Settings) -> CheckResult:
    """A bracket welded to the wall with a boom on a hinge that dry friction holds level, told from either end.

    A soft friction gives way until it bears all of the moment, by e for each 3 ms or so: a tenth of a second is e^-30.
    """
    bracket, boom = free("bracket", mass=2.0, p=(0.5, 0.0, 1.0)), free("boom", mass=1.0, p=(1.4, 0.2, 1.0), q=TURNED)
    moment, comparisons = 1.0 * G * 0.4, list[Compared]()
    hinge = np.array((0.0, 0.0, 1.0 * G, 0.2 * 1.0 * G, -moment, 0.0))
    for parent, child, sign in (("bracket", "boom", 1.0), ("boom", "bracket", -1.0)):
        joints = (
            Fixed(name="weld", parent=WORLD, child="bracket"),
            Revolute(
                name="hinge", parent=parent, child=child, anchor_W=(1.0, 0.0, 1.0), axis_W=(0.0, 1.0, 0.0), friction_loss=8.0
            ),
        )
        reactions = _reactions(adapter, Scene(bodies=(bracket, boom), joints=joints), settings.with_dt(FINE), 100)
        comparisons.append(
            near(
                f"force and torque of the hinge on the {child} [N, N m]",
                reactions[1],
                sign * hinge,
                _SETTLED * G,
                "weight times arm",
            )
        )
    return judge(*comparisons)


@check("Does what a joint carries hold a swinging body in its circle, beside its weight?", Feature.REVOLUTE)
def joint_reactions_at_the_bottom_of_a_swing(adapter: Adapter, settings: Settings) -> CheckResult:
    """A ball of 2 kg, .7 m below its hinge and askew in its own frame, at 3 rad/s: m (g + w^2 l) as it passes the bottom."""
    mass, length, w, steps = 2.0, 0.7, 3.0, 4
    axis, across = np.array([0.6, 0.8, 0.0]), np.array([0.8, -0.6, 0.0])
    # The speed changes by the cosine of four steps' turn alone, 7e-5 of it.
    behind = -w * steps * FINE
    arm = length * (-np.sin(behind) * across - np.cos(behind) * np.array([0.0, 0.0, 1.0]))
    pivot = np.array([0.3, -0.2, 1.0])
    bob = free("bob", mass=mass, p=_v(pivot + arm), q=TURNED, v=_v(np.cross(w * axis, arm)), w=_v(w * axis))
    hinge = Revolute(name="hinge", parent=WORLD, child="bob", anchor_W=_v(pivot), axis_W=_v(axis))
    told = _reactions(adapter, Scene(bodies=(bob,), joints=(hinge,)), settings.with_dt(FINE), steps)
    tension = mass * (G + w * w * length)
    because = "m (g + w^2 l) upwards, and no torque on a round body; a step turns it by w dt, which is what engines differ by"
    return judge(
        near(
            "force and torque at the bottom [N, N m]",
            told[0],
            (0.0, 0.0, tension, 0.0, 0.0, 0.0),
            2.0 * w * FINE * tension,
            because,
        )
    )


@check("Does each joint of a chain at rest carry the weight of all that hangs below it?", Feature.BALL)
def joint_reactions_add_up_along_a_chain(adapter: Adapter, settings: Settings) -> CheckResult:
    """Bodies of 1, 2 and 3 kg under each other on ball joints, gravity askew: each joint bears what hangs below it."""
    down = np.array([0.36, 0.48, -0.8])
    masses = (1.0, 2.0, 3.0)
    bodies = tuple(free(f"link{k}", mass=m, p=_v((0.2 + 0.4 * k) * down), q=TURNED) for k, m in enumerate(masses))
    ends = (WORLD, "link0", "link1")
    joints = tuple(
        Ball(name=f"joint{k}", parent=above, child=f"link{k}", anchor_W=_v(0.4 * k * down)) for k, above in enumerate(ends)
    )
    told = _reactions(adapter, Scene(bodies=bodies, joints=joints, gravity=_v(G * down)), settings.with_dt(FINE), 10)
    wanted = [(*(-sum(masses[k:]) * G * down), 0.0, 0.0, 0.0) for k in range(3)]
    return judge(near("forces and torques along the chain [N, N m]", told, wanted, _SETTLED * G, "the weight of all below"))


@check("Is what a contact bears left out of what the engine tells of a joint?", Feature.REVOLUTE | Feature.SPHERE)
def joint_reactions_beside_contacts(adapter: Adapter, settings: Settings) -> CheckResult:
    """A beam with one end on a hinge and a ball under the other that lies on the ground: each bears half of it."""
    foot = PlacedShape(shape=Sphere(radius=0.1), p_BS=(0.5, 0.0, 0.0))
    beam = replace(free("beam", mass=2.0, moments=(0.1, 0.2, 0.2), p=(0.0, 0.0, 0.1)), collision=(foot,), material="block")
    hinge = Revolute(name="hinge", parent=WORLD, child="beam", anchor_W=(-0.5, 0.0, 0.1), axis_W=(0.0, 1.0, 0.0))
    scene = Scene(bodies=(floor(adapter), beam), joints=(hinge,), surfaces=(ground(0.0),))
    told = _reactions(adapter, scene, settings.with_dt(FINE), 1000)
    half, within = 0.5 * 2.0 * G, 2.0 * _SETTLED * G
    because = "moments about the foot: half of the beam's weight, and no torque about the axis"
    return judge(
        near("force and torque of the hinge on the beam [N, N m]", told[0], (0.0, 0.0, half, 0.0, 0.0, 0.0), within, because)
    )
