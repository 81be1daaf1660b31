"""Checks of what an engine itself tells of joints: coordinates and rates against poses, forces and torques against statics."""

from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature, Simulation
from plumbline.harness.adapter.joints import joints_of
from plumbline.harness.conformance.check import Comparisons, NotApplicable, check, near, that
from plumbline.harness.conformance.engine import FINE, ROUNDING, Engine, state_of
from plumbline.harness.conformance.frames import TURNED, X, Y, vector
from plumbline.harness.conformance.scenes import G, floor, free, ground, prismatic, revolute, without_gravity
from plumbline.harness.scene import WORLD, Ball, Fixed, PlacedShape, Scene, Sphere, Spring
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.joint_states import JointStates, joint_states


def _read(simulation: Simulation) -> JointStates:
    """What the engine itself says. Raises: NotApplicable."""
    read: Any = getattr(simulation, "joint_states", None)
    if read is None:
        raise NotApplicable("the engine tells nothing of joints: they are read off the poses of the bodies")
    states: JointStates = read()
    return states


def _told(simulation: Simulation) -> JointStates:
    """What the engine itself says of coordinates. Raises: NotApplicable."""
    states = _read(simulation)
    if np.isnan(states.coordinate).all():
        raise NotApplicable("the engine tells no coordinates of joints: they are read off the poses of the bodies")
    return states


@check(
    "Are the coordinates and rates that the engine tells those of its bodies?",
    Feature.REVOLUTE | Feature.PRISMATIC | Feature.FIXED | Feature.SPRINGS,
)
def joint_states_agree_with_the_poses(engine: Engine) -> Comparisons:
    """A wheel that turns more than once, a slide on it, and a hinge whose child carries its parent, all off their zeros."""
    axis, hub, w = np.array([1.0, 2.0, 2.0]) / 3, np.array([0.2, 0.1, 0.0]), 30.0
    spin = w * axis
    flap = free("flap", p=(1.0, 0.5, -0.3), moments=(0.1, 0.2, 0.25), w=Y)
    bodies = [
        free(name, p=vector(p), q=TURNED, v=vector(np.cross(spin, p - hub)), w=vector(spin))
        for name, p in (("wheel", hub), ("carriage", np.array([0.6, 0.1, 0.0])))
    ]
    spring = Spring(stiffness=3000.0, rest=0.3)
    joints = (
        revolute("hub", "wheel", vector(hub), vector(axis), position=-0.5),
        prismatic("slide", "carriage", vector(hub), (0.6, 0.8, 0.0), position=0.3, spring=spring, parent="wheel"),
        Fixed(name="foot", parent=WORLD, child="post"),
        revolute("hinge", "post", flap.p_WB, Y, position=0.2, parent="flap"),
    )
    scene = without_gravity(*bodies, flap, free("post", p=X), joints=joints)
    with engine.built(scene) as simulation:
        started = _told(simulation)
        simulation.step(300)
        states = _told(simulation)
        meant = joint_states(scene, state_of(simulation, scene), near=states.coordinate)
        filled = joints_of(simulation, scene)
    moving = [0, 1, 3]
    because = "the same numbers, by rounding"
    yield near("coordinates at the start", started.coordinate[moving], (-0.5, 0.3, 0.2), ROUNDING, "the scene's positions")
    yield near(
        "rates at the start", started.rate[moving], (w, 0.0, -1.0), ROUNDING * w, "the scene's velocities, child over parent"
    )
    yield near("coordinates against the poses", states.coordinate[moving], meant.coordinate[moving], ROUNDING, because)
    yield near("rates against the velocities", states.rate[moving], meant.rate[moving], ROUNDING * w, because)
    got = f"angle of the wheel: got {states.coordinate[0]:.6g} rad"
    yield that(states.coordinate[0] > 2.0 * np.pi, f"{got}, expected more than a turn after .3 s at 30 rad/s")
    yield near("what the harness reads", filled.coordinate[moving], states.coordinate[moving], 0.0, "the engine's own")


_SETTLED = 1e-3
"""Share of the weights that what rests may still move by, after so many steps."""


def _reactions(engine: Engine, scene: Scene, steps: int) -> Floats:
    """The reactions (j, 6) after some steps, to an engine that was told beforehand that it will be asked.

    Raises: NotApplicable.
    """
    with engine.built(scene) as simulation:
        _read(simulation)
        simulation.step(steps)
        reaction: Floats = _read(simulation).reaction
    if np.isnan(reaction).all():
        raise NotApplicable("the engine tells no reactions of joints")
    return reaction


_MOMENT = 1.0 * G * 0.4
_BORNE = (0.0, 0.0, 1.0 * G, 0.2 * 1.0 * G, -_MOMENT, 0.0)
"""Force and torque of the hinge on the boom [N, N m]."""


def _bracket_and_boom(parent: str, child: str, **laws: Any) -> Scene:
    """A bracket welded to the wall with a boom on a hinge, which of the two is its parent being told."""
    bracket, boom = free("bracket", p=(0.5, 0.0, 1.0)), free("boom", mass=1.0, p=(1.4, 0.2, 1.0), q=TURNED)
    weld = Fixed(name="weld", parent=WORLD, child="bracket")
    hinge = revolute("hinge", child, (1.0, 0.0, 1.0), Y, parent=parent, **laws)
    return Scene(bodies=(bracket, boom), joints=(weld, hinge))


@check(
    "Are the forces and torques that the engine tells of joints those that hold up what hangs on them?",
    Feature.REVOLUTE | Feature.FIXED | Feature.SPRINGS,
)
def joint_reactions_bear_what_hangs(engine: Engine) -> Comparisons:
    """A bracket welded to the wall with a boom on a hinge, held level by its spring: weights and their moments, at rest."""
    # About y a weight at +x turns positively: the spring has to hold against it.
    spring = Spring(stiffness=1000.0, damping=50.0, rest=-_MOMENT / 1000.0)
    told = _reactions(engine, _bracket_and_boom("bracket", "boom", spring=spring), 10)
    weld = (0.0, 0.0, 3.0 * G, 0.2 * 1.0 * G, -0.9 * 1.0 * G, 0.0)
    yield near("force and torque of the weld on the bracket [N, N m]", told[0], weld, _SETTLED * G, "weight times arm")
    yield near("force and torque of the hinge on the boom [N, N m]", told[1], _BORNE, _SETTLED * G, "weight times arm")


@check(
    "Is what dry friction bears in what the engine tells of a joint, whichever of its bodies hangs on the other?",
    Feature.REVOLUTE | Feature.FIXED | Feature.FRICTION_LOSS,
)
def joint_reactions_bear_what_friction_holds(engine: Engine) -> Comparisons:
    """A bracket welded to the wall with a boom on a hinge that dry friction holds level, told from either end.

    A soft friction gives way until it bears all of the moment, by e for each 3 ms or so: a tenth of a second is e^-30.
    """
    for parent, child, sign in (("bracket", "boom", 1.0), ("boom", "bracket", -1.0)):
        reaction = _reactions(engine, _bracket_and_boom(parent, child, friction_loss=8.0), 100)[1]
        what = f"force and torque of the hinge on the {child} [N, N m]"
        yield near(what, reaction, sign * np.array(_BORNE), _SETTLED * G, "weight times arm")


@check("Does what a joint carries hold a swinging body in its circle, beside its weight?", Feature.REVOLUTE)
def joint_reactions_at_the_bottom_of_a_swing(engine: Engine) -> Comparisons:
    """A ball of 2 kg, .7 m below its hinge and askew in its own frame, at 3 rad/s: m (g + w^2 l) as it passes the bottom."""
    mass, length, w, steps = 2.0, 0.7, 3.0, 4
    axis, across = np.array([0.6, 0.8, 0.0]), np.array([0.8, -0.6, 0.0])
    # The speed changes by the cosine of four steps' turn alone, 7e-5 of it.
    behind = -w * steps * FINE
    arm = length * (-np.sin(behind) * across - np.cos(behind) * np.array([0.0, 0.0, 1.0]))
    pivot = np.array([0.3, -0.2, 1.0])
    bob = free("bob", mass=mass, p=vector(pivot + arm), q=TURNED, v=vector(np.cross(w * axis, arm)), w=vector(w * axis))
    hinge = revolute("hinge", "bob", vector(pivot), vector(axis))
    told = _reactions(engine, Scene(bodies=(bob,), joints=(hinge,)), steps)
    tension = mass * (G + w * w * length)
    because = "m (g + w^2 l) upwards, and no torque on a round body; a step turns it by w dt, which is what engines differ by"
    expected = (0.0, 0.0, tension, 0.0, 0.0, 0.0)
    yield near("force and torque at the bottom [N, N m]", told[0], expected, 2.0 * w * FINE * tension, because)


@check("Does each joint of a chain at rest carry the weight of all that hangs below it?", Feature.BALL)
def joint_reactions_add_up_along_a_chain(engine: Engine) -> Comparisons:
    """Bodies of 1, 2 and 3 kg under each other on ball joints, gravity askew: each joint bears what hangs below it."""
    down = np.array([0.36, 0.48, -0.8])
    masses = (1.0, 2.0, 3.0)
    bodies = tuple(free(f"link{k}", mass=m, p=vector((0.2 + 0.4 * k) * down), q=TURNED) for k, m in enumerate(masses))
    ends = (WORLD, "link0", "link1")
    joints = tuple(
        Ball(name=f"joint{k}", parent=above, child=f"link{k}", anchor_W=vector(0.4 * k * down)) for k, above in enumerate(ends)
    )
    told = _reactions(engine, Scene(bodies=bodies, joints=joints, gravity=vector(G * down)), 10)
    wanted = [(*(-sum(masses[k:]) * G * down), 0.0, 0.0, 0.0) for k in range(3)]
    yield near("forces and torques along the chain [N, N m]", told, wanted, _SETTLED * G, "the weight of all below")


@check("Is what a contact bears left out of what the engine tells of a joint?", Feature.REVOLUTE | Feature.SPHERE)
def joint_reactions_beside_contacts(engine: Engine) -> Comparisons:
    """A beam with one end on a hinge and a ball under the other that lies on the ground: each bears half of it."""
    foot = PlacedShape(shape=Sphere(radius=0.1), p_BS=(0.5, 0.0, 0.0))
    beam = replace(free("beam", mass=2.0, moments=(0.1, 0.2, 0.2), p=(0.0, 0.0, 0.1)), collision=(foot,), material="block")
    hinge = revolute("hinge", "beam", (-0.5, 0.0, 0.1), Y)
    scene = Scene(bodies=(floor(engine), beam), joints=(hinge,), surfaces=(ground(0.0),))
    told = _reactions(engine, scene, 1000)
    half, within = 0.5 * 2.0 * G, 2.0 * _SETTLED * G
    because = "moments about the foot: half of the beam's weight, and no torque about the axis"
    yield near("force and torque of the hinge on the beam [N, N m]", told[0], (0.0, 0.0, half, 0.0, 0.0, 0.0), within, because)
