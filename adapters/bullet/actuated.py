"""Which springs, drives and rotors of a tree act how: at the step's start, at its end, or as Bullet's own motors."""

import math
from collections.abc import Sequence

import numpy as np

from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.adapters.bullet.drives import Actuation, Actuator
from plumbline.adapters.bullet.effective_mass import Footing, Skeleton
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.trees import Tree, joint_axis
from plumbline.harness.adapter import Notice, Unsupported
from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.adapter.rotors import WHY
from plumbline.harness.scene import WORLD, Effect, Joint, Prismatic, Revolute, Scene, rotate

SAME_POSE = 0.05
"""How far [rad] joints may turn, or slide in units of a radius of gyration, before their mobility counts as another."""
MOTORS = (
    "deviation: drives are Bullet's own position motors, rigid up to their limit: velocity constraints without a stiffness "
    "in N m/rad, which approach the target at stiffness/damping a second and do not give way under load"
)


def actuated(plan: Plan, made: Assembly, tree: Tree) -> Actuation | None:
    """The springs, drives and rotors of a tree; None where it has none. Raises: Unsupported."""
    acted: list[tuple[Joint, Actuator]] = []
    motors: list[Actuator] = []
    for k, link in enumerate(tree.links):
        if isinstance(link.joint, Revolute | Prismatic):
            joint = link.joint
            drive = joint.drive if Effect.DRIVES in plan.effects else None
            target = 0.0 if drive is None else drive.target
            if drive is not None and plan.options["drives"] == "motor" and drive.stiffness + drive.damping > 0:
                if joint.friction_loss:
                    raise Unsupported(f"joint '{joint.name}': dry friction beside a motor", "a joint of Bullet has one motor")
                if drive.feedforward:
                    raise Unsupported(
                        f"joint '{joint.name}': feedforward", "Bullet's own motors hold a velocity and take no torque beside"
                    )
                motors.append(Actuator(joint.name, k, joint.position, None, drive, target))
                drive = None
            rotor = joint.armature or 0.0
            if joint.spring is not None or drive is not None or rotor > 0:
                acted.append((joint, Actuator(joint.name, k, joint.position, joint.spring, drive, target, rotor)))
    rotors = any(actuator.armature for _, actuator in acted)
    if motors and rotors:
        raise Unsupported(f"joint '{motors[0].joint}': a motor beside joints with rotors", WHY)
    if motors:
        made.notices.append(Notice(MOTORS))
    if not acted and not motors:
        return None
    actuators, skeleton = tuple(actuator for _, actuator in acted), None
    reach = np.full(len(acted), SAME_POSE)
    if rotors or (acted and _reversing(acted, plan.scene, plan.h)):
        skeleton = Skeleton.of(tree, plan.scene, plan.principal, {actuator.link for actuator in actuators})
        for k, (acting, _) in enumerate(acted):
            if isinstance(acting, Prismatic):
                child = plan.scene.index(acting.child)
                reach[k] *= math.sqrt(max(plan.principal[child][0]) / plan.scene.bodies[child].mass)
        if len(skeleton.acted) < len(skeleton.moved):
            # Coordinates that nothing acts on are not looked at.
            reach[:] = -1.0
    return Actuation(actuators, plan.h, skeleton, reach, _footing(plan, made, tree), plan.gravity, tuple(motors))


def _footing(plan: Plan, made: Assembly, tree: Tree) -> Footing:
    """What stands still that the bodies of a tree without a fixed base may stand on."""
    friction: dict[tuple[int, int], float] = {}
    if tree.base is None or not plan.scene.bodies[tree.base].movable:
        return Footing(friction)
    places = [(-1, tree.base), *((k, link.place) for k, link in enumerate(tree.links))]
    for (number, _), other in made.address.items():
        ground = plan.scene.bodies[other]
        for link, place in places:
            body = plan.scene.bodies[place]
            if plan.solid and ground.motion == "static" and plan.scene.collides(body, ground):
                rubs = Effect.FRICTION in plan.effects
                friction[link, number] = plan.scene.surface(body, ground).kinetic_friction if rubs else 0.0
    return Footing(friction)


def _reversing(acted: Sequence[tuple[Joint, Actuator]], scene: Scene, h: float) -> bool:
    """May efforts held over a step of h [s] reverse a velocity within it, in some pose?

    With the efforts of the step's start, semi-implicit Euler is stable while the eigenvalues of h W (D + h K/2) stay below 2,
    and reverses nothing while they stay below 1; K and D hold stiffness and damping. Bodies let loose from all other
    constraints are more mobile than W, which bounds the eigenvalues, in every pose where joints are revolute: their axes lie
    fixed in both bodies.
    """
    massless = {body.name for body in scene.bodies if body.massless}
    if any({joint.parent, joint.child} & massless for joint, _ in acted):
        # Let loose, a body without mass is as mobile as can be.
        return True
    names = {body.name: place for place, body in enumerate(scene.bodies)}
    pushes = np.zeros((len(acted), len(scene.bodies), 6))
    for push, (joint, actuator) in zip(pushes, acted, strict=True):
        springs = [law for law in (actuator.spring, actuator.drive) if law is not None]
        size = math.sqrt(h * sum(law.damping + h * law.stiffness / 2 for law in springs))
        child = scene.body(joint.child)
        for name, sign in ((joint.child, size), (joint.parent, -size)):
            if name == WORLD or not scene.bodies[names[name]].movable:
                continue
            body, axis = scene.bodies[names[name]], sign * np.asarray(joint_axis(joint, joint.child))
            force, torque = np.zeros(3), axis
            if isinstance(joint, Prismatic):
                force, torque = axis, np.cross(np.subtract(child.p_WB, body.p_WB), axis)
            turned = rotate(conjugate(body.q_WB), (float(torque[0]), float(torque[1]), float(torque[2])))
            push[names[name], :3] = force / math.sqrt(body.mass)
            push[names[name], 3:] = np.linalg.solve(np.linalg.cholesky(np.asarray(body.inertia)), turned)
    flat = pushes.reshape(len(acted), -1)
    return bool(np.linalg.eigvalsh(flat @ flat.T).max() >= 1.0)
