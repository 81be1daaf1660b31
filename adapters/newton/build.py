"""A scene becomes a model of Newton and a solver: everything in its order."""

import math
from dataclasses import replace
from typing import Any

from plumbline.adapters.newton.bodies import Bodies
from plumbline.adapters.newton.joints import Joints
from plumbline.adapters.newton.many_worlds import Layout, NewtonWorlds
from plumbline.adapters.newton.options import resolved_settings
from plumbline.adapters.newton.simulation import NewtonSimulation, World
from plumbline.adapters.newton.stepper import NoContacts, Stepper
from plumbline.adapters.newton.surfaces import numbers_of, rebounds
from plumbline.adapters.newton.vendor import Vendor, mujoco_solver
from plumbline.harness.adapter import Notice, Settings
from plumbline.harness.adapter.carried_laws import refuse_tendons
from plumbline.harness.adapter.distance_springs import DistanceSprings, is_distance_spring
from plumbline.harness.adapter.rolling import CORRECTIONS, balls_alone
from plumbline.harness.scene import WORLD, Effect, Joint, Prismatic, Revolute, Scene

VENDOR_TIME_CONSTANT = 0.02
"""Of MuJoCo's contacts [s]."""
LIMIT_DAMPING_RATIO, LIMIT_IMPEDANCE = 1.7, 0.999
"""Of joint limits, as `adapters.mujoco` measured them to rebound least."""
RAW = 1
"""Newton's word for a softness that is told in MuJoCo's own numbers."""
_SOFT = (2.5e3, 100.0)
"""Newton's ke and kd of shapes, which are a time constant of .02 s and a damping ratio of 1."""


def build(vendor: Vendor, scene: Scene, settings: Settings) -> NewtonSimulation:
    """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
    effects, used = scene.effects, resolved(scene, settings)
    builder, bodies, joints = _told(vendor, scene, used)
    model = builder.finalize(device="cpu")
    moving = _solver(vendor, model, used, effects, _room(scene)) if model.body_count else None
    world = World(vendor, model, moving, bodies.links, bodies.owners, joints.driven, _pipeline(vendor, model, used, effects))
    if Effect.JOINTS in effects:
        world.springs = DistanceSprings.of(scene, scene.joints, used.substep)
    world.notices += _notices(scene, effects)
    return NewtonSimulation(scene, used, world)


def together(scene: Scene) -> bool:
    """Can many worlds of a scene be one model? Not where an adapter has to do something in each sub-step."""
    led = any(body.motion == "kinematic" or body.mass_point for body in scene.bodies)
    sprung = Effect.JOINTS in scene.effects and any(is_distance_spring(joint) for joint in scene.joints)
    return not (led or sprung) and any(body.movable for body in scene.bodies)


def build_worlds(vendor: Vendor, scene: Scene, settings: Settings, count: int) -> NewtonWorlds:
    """`count` worlds of this scene in one model. Raises: Unsupported, SettingsError."""
    effects, used = scene.effects, resolved(scene, settings)
    one, bodies, joints = _told(vendor, scene, used)
    builder = _builder(vendor, scene)
    builder.replicate(one, count)
    model = builder.finalize(device="cpu")
    pipeline = _pipeline(vendor, model, used, effects)
    stepper = Stepper(vendor, model, _solver(vendor, model, used, effects, _room(scene)), pipeline, used.substep)
    return NewtonWorlds(scene, used, stepper, Layout(count, bodies.links, joints.driven), tuple(_notices(scene, effects)))


def resolved(scene: Scene, settings: Settings) -> Settings:
    """The settings with what suits the scene where they leave something open. Raises: SettingsError."""
    smooth = all(is_smooth(scene, joint, settings.substep) for joint in scene.joints)
    used = resolved_settings(settings, "xpbd" if rebounds(scene) else "mujoco", scene.effects, smooth)
    alone = used.options.get("rolling_impratio")
    led = any(body.motion == "kinematic" for body in scene.bodies)  # on which the slip correction errs by a third more
    if alone is None or led or not balls_alone(scene):
        return used
    corrections = used.options["noslip_iterations"] or CORRECTIONS
    return replace(used, options={**used.options, "impratio": alone, "noslip_iterations": corrections})


def is_smooth(scene: Scene, joint: Joint, h: float) -> bool:
    """Do a joint's laws leave its motion as smooth as RK4 needs it: no stop, dry friction or drive, no spring beyond h [s]?"""
    if not isinstance(joint, Revolute | Prismatic):
        return not is_distance_spring(joint)  # whose force the adapter holds over a step
    if joint.limits is not None or joint.friction_loss or joint.drive is not None:
        return False
    spring, lightest = joint.spring, min(scene.body(name).mass for name in (joint.parent, joint.child) if name != WORLD)
    if spring is None or isinstance(joint, Revolute):
        return spring is None
    return max(h * spring.damping, h * math.sqrt(spring.stiffness * lightest)) < lightest


def _builder(vendor: Vendor, scene: Scene) -> Any:
    """A model that is to be made."""
    builder = vendor.newton.ModelBuilder(gravity=scene.gravity if Effect.GRAVITY in scene.effects else (0.0, 0.0, 0.0))
    builder.balance_inertia = False
    vendor.newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    return builder


def _told(vendor: Vendor, scene: Scene, used: Settings) -> tuple[Any, Bodies, Joints]:
    """All of a scene, in a model that is to be made. Raises: Unsupported."""
    refuse_tendons(scene)
    builder, solver = _builder(vendor, scene), str(used.solver)
    bodies = Bodies(vendor, builder, scene, solver, numbers_of(scene, solver), _softness(used), _impedance(used))
    bodies.put()
    joints = Joints(bodies, solver, _held(used))
    joints.put()
    bodies.keep_apart()
    return builder, bodies, joints


def _pipeline(vendor: Vendor, model: Any, used: Settings, effects: Effect) -> Any:
    """What finds contacts, where MuJoCo-Warp does not find its own."""
    touches = Effect.CONTACT in effects
    if used.solver == "xpbd":
        return vendor.newton.CollisionPipeline(model) if touches else NoContacts()
    return vendor.newton.CollisionPipeline(model) if touches and used.options["contacts"] == "newton" else None


def _softness(used: Settings) -> tuple[float, float]:
    """(ke, kd) of contacts: of MuJoCo's time constant t and damping ratio z Newton makes kd = 2/t and ke = 1/(t z)^2."""
    steps = used.options.get("contact_steps")
    if steps is None:
        return _SOFT
    t = max(2.0 * used.substep, min(steps * used.substep, VENDOR_TIME_CONSTANT))
    return 1.0 / (t * used.options["contact_damping_ratio"]) ** 2, 2.0 / t


def _impedance(used: Settings) -> dict[str, Any]:
    """How little a contact gives way under load, by MuJoCo's attribute of a shape; nothing for the vendor's own."""
    share = used.options.get("contact_impedance")
    return {} if share is None else {"mujoco:geom_solimp": (share, share, 0.001, 0.5, 2.0)}


def _held(used: Settings) -> dict[str, Any]:
    """How stiffly limits and dry friction hold a coordinate, by MuJoCo's attributes of one; nothing for Newton's own."""
    steps = used.options.get("limit_steps")
    if steps is None:
        return {}
    t, stiff = min(steps * used.substep, VENDOR_TIME_CONSTANT), (LIMIT_IMPEDANCE, LIMIT_IMPEDANCE, 0.001, 0.5, 2.0)
    return {
        "mujoco:solreflimit": [(t, LIMIT_DAMPING_RATIO)],
        "mujoco:solreflimit_mode": [RAW],
        "mujoco:solimplimit": [stiff],
        "mujoco:solreffriction": [(t, 1.0)],
        "mujoco:solimpfriction": [stiff],
    }


def _room(scene: Scene) -> tuple[int, int]:
    """For how many contacts and rows of constraints there is room in a world; Newton's own guess is from those of the start.

    A pair of shapes has at most 8 points; in a heap a shape has a dozen neighbours, shared with them, and 4 points with each.
    A contact has at most 4 rows, a joint at most 8. Kernels of MuJoCo-Warp are compiled for each number of rows anew: scenes of
    like size share those of a power of two.
    """
    moving = sum(len(body.collision) for body in scene.bodies if body.movable)
    every = sum(len(body.collision) for body in scene.bodies)
    contacts = max(16, min(8 * moving * (every - 1), 32 * moving)) if Effect.CONTACT in scene.effects else 0
    rows = 4 * contacts + 8 * (len(scene.joints) + len(scene.bodies)) + 16
    return contacts, max(64, 1 << (rows - 1).bit_length())


def _solver(vendor: Vendor, model: Any, used: Settings, effects: Effect, room: tuple[int, int]) -> Any:
    options = used.options
    if used.solver == "xpbd":
        return vendor.newton.solvers.SolverXPBD(
            model,
            iterations=used.iterations,
            rigid_contact_relaxation=options["contact_relaxation"],
            rigid_contact_con_weighting=options["contact_weighting"],
            rigid_contact_restitution_iterations=options["restitution_iterations"],
            enable_restitution=Effect.RESTITUTION in effects,
        )
    solver = mujoco_solver(
        vendor.newton,
        model,
        iterations=used.iterations,
        integrator=used.integrator,
        cone=options["cone"],
        impratio=options["impratio"],
        use_mujoco_contacts=options["contacts"] == "mujoco" or Effect.CONTACT not in effects,
        enable_multiccd=options["multiccd"],
        disable_contacts=Effect.CONTACT not in effects,
        nconmax=room[0] or None,
        njmax=room[1],
        kinematic_switchable_roots=False,
    )
    solver.mjw_model.opt.noslip_iterations = options["noslip_iterations"]  # Newton has no word for it
    return solver


def _notices(scene: Scene, effects: Effect) -> list[Notice]:
    """What is computed although the scene does not call for it, and what is not although it does."""
    notices, movable = [], [body for body in scene.bodies if body.movable]
    if Effect.CONTINUOUS_COLLISION in effects:
        text = "continuous collision: Newton's solvers have none"
        notices.append(Notice(text, "missing", Effect.CONTINUOUS_COLLISION))
    uneven = any(body.inertia[0][0] != body.inertia[1][1] or body.inertia[1][1] != body.inertia[2][2] for body in movable)
    if Effect.GYROSCOPIC not in effects and uneven:
        notices.append(Notice("gyroscopic terms, for which Newton offers no switch", "surplus", Effect.GYROSCOPIC))
    return notices
