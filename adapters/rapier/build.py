"""A scene becomes a world of Rapier: everything in its order."""

from collections.abc import Mapping
from typing import Any

from plumbline.adapters.rapier.bodies import builder_of, check_body, colliders_of
from plumbline.adapters.rapier.joints import put_joints
from plumbline.adapters.rapier.options import resolved_settings, set_parameters
from plumbline.adapters.rapier.simulation import Made, RapierSimulation
from plumbline.adapters.rapier.surfaces import Law, PairLaws, groups_of, laws_of
from plumbline.harness.adapter import Notice, Settings
from plumbline.harness.scene import WORLD, Effect, Scene


def build(rapier: Any, scene: Scene, settings: Settings) -> RapierSimulation:
    """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
    used, effects = resolved_settings(settings), scene.effects
    world = rapier.PhysicsWorld(gravity=scene.gravity if Effect.GRAVITY in effects else (0.0, 0.0, 0.0))
    set_parameters(rapier, world, used)
    if Effect.CONTINUOUS_COLLISION not in effects:
        world.integration_parameters.max_ccd_substeps = 0
    made = Made(rapier, world)
    _put_bodies(made, scene, effects, used)
    if Effect.JOINTS in effects:
        handles = dict(zip((body.name for body in scene.bodies), made.handles, strict=True))
        if any(WORLD in (joint.parent, joint.child) for joint in scene.joints):
            handles[WORLD] = world.add_body(rapier.RigidBody.fixed(), [])
        made.drives = dict(put_joints(rapier, scene, scene.joints, handles, world.impulse_joints.insert))
    return RapierSimulation(scene, used, made)


def _put_bodies(made: Made, scene: Scene, effects: Effect, used: Settings) -> None:
    """All bodies in the order of the scene, with the law of contact of each pair. Raises: Unsupported."""
    rapier, world, laws = made.rapier, made.world, laws_of(scene)
    for body in scene.bodies:
        check_body(body)
        made.handles.append(world.add_body(builder_of(rapier, body, effects, used), []))
    if Effect.CONTACT not in effects:
        nobody = dict.fromkeys({body.material for body in scene.bodies}, rapier.InteractionGroups.none())
        made.unseen = lambda: _put_shapes(made, scene, used, {}, nobody)
    else:
        _put_shapes(made, scene, used, laws, groups_of(rapier, scene))
    if used.options["sleeping"] and any(body.movable for body in scene.bodies):
        made.notices.append(Notice("bodies slower than 0.05 m/s and 0.5 rad/s for half a second are put to sleep"))


def _put_shapes(
    made: Made, scene: Scene, used: Settings, laws: Mapping[frozenset[str], Law], groups: Mapping[str, Any]
) -> None:
    """The shapes of all bodies. Args: laws: by pair of materials. groups: by material, whom it meets."""
    rapier, world = made.rapier, made.world
    alike = len(set(laws.values())) <= 1
    friction, restitution = next(iter(laws.values()), (0.0, 0.0))
    materials: dict[int, str] = {}
    for place, (body, handle) in enumerate(zip(scene.bodies, made.handles, strict=True)):
        for collider in colliders_of(rapier, body, used.options["inner_edges"]):
            told = collider.friction(friction).restitution(restitution)
            if body.material in groups:
                told = told.collision_groups(groups[body.material])
            if not alike:
                told = told.active_hooks(rapier.ActiveHooks.MODIFY_SOLVER_CONTACTS)
            index = world.add_collider(told, handle).index
            made.owners[index], materials[index] = place, body.material
    if not alike:
        world.physics_hooks = PairLaws(laws, materials, rapier.SolverFlags.COMPUTE_IMPULSES)
