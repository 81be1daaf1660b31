"""A scene becomes a world of Rapier: everything in its order."""

from collections.abc import Collection, Mapping
from typing import Any

from plumbline.adapters.rapier.bodies import builder_of, check_body, colliders_of
from plumbline.adapters.rapier.joints import Joiner, of_reduced_alone
from plumbline.adapters.rapier.options import resolved_settings, set_parameters
from plumbline.adapters.rapier.simulation import Made, RapierSimulation
from plumbline.adapters.rapier.surfaces import Law, PairLaws, groups_of, laws_of
from plumbline.adapters.rapier.trees import put_trees
from plumbline.adapters.rapier.vendor import pose
from plumbline.harness.adapter import Notice, Settings, Unsupported
from plumbline.harness.adapter.between import on_massless
from plumbline.harness.adapter.carried_laws import refuse_tendons
from plumbline.harness.adapter.reduced_trees import trees_of
from plumbline.harness.scene import WORLD, Effect, Scene


def build(rapier: Any, scene: Scene, settings: Settings) -> RapierSimulation:
    """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
    effects = scene.effects
    used = resolved_settings(settings, effects)
    if Effect.JOINTS in effects:
        refuse_tendons(scene)
    between = on_massless(scene)
    world = rapier.PhysicsWorld(gravity=scene.gravity if Effect.GRAVITY in effects else (0.0, 0.0, 0.0))
    set_parameters(rapier, world, used)
    if Effect.CONTINUOUS_COLLISION not in effects:
        world.integration_parameters.max_ccd_substeps = 0
    contents = Made(rapier, world)
    for body in scene.bodies:
        check_body(body)
        contents.handles.append(world.add_body(builder_of(rapier, body, effects, used), []))
    if Effect.JOINTS in effects:
        # What impulse joints have not, trees in reduced coordinates have, on any track.
        needed = bool(between) or any(of_reduced_alone(joint, effects) for joint in scene.joints)
        _join(contents, scene, needed or used.options["joints"] == "multibody", between)
    _put_shapes(contents, scene, effects, used)
    if used.options["sleeping"] and any(body.movable for body in scene.bodies):
        contents.notices.append(Notice("bodies slower than 0.1 m/s and 0.5 rad/s for half a second are put to sleep"))
    return RapierSimulation(scene, used, contents)


def _join(contents: Made, scene: Scene, reduced: bool, between: Collection[str]) -> None:
    """All joints.

    Args: reduced: trees of them in reduced coordinates. between: names of those that end at a body without mass.
    Raises: Unsupported.
    """
    rapier, world = contents.rapier, contents.world
    handles = dict(zip((body.name for body in scene.bodies), contents.handles, strict=True))
    joiner = Joiner(rapier, world, scene, handles)
    trees = trees_of(scene, scene.joints) if reduced else []

    def root(name: str) -> Any:
        """A body that moves, or one without shapes in the place of what stands still: links have the friction of 'coulomb'."""
        still = rapier.RigidBody.fixed()
        if name != WORLD:
            body = scene.body(name)
            if body.movable:
                return handles[name]
            still = still.position(pose(rapier, body.p_WB, body.q_WB))
        return world.add_body(still, [])

    put_trees(world, scene, trees, root, joiner.link)
    held = {branch.edge.name for tree in trees for branch in tree.branches}
    loose = [joint for joint in scene.joints if joint.name not in held]
    if free := next((joint.name for joint in loose if joint.name in between), None):
        raise Unsupported(
            f"joint '{free}' of a body without mass", "Rapier has links without mass in reduced coordinates alone"
        )
    if any(WORLD in (joint.parent, joint.child) for joint in loose):
        handles[WORLD] = world.add_body(rapier.RigidBody.fixed(), [])
    for joint in loose:
        joiner.put(joint)
    contents.drives = joiner.drives


def _put_shapes(contents: Made, scene: Scene, effects: Effect, used: Settings) -> None:
    """The shapes of all bodies, now, or where they touch nothing, when the first ray is cast. Raises: Unsupported."""
    laws = laws_of(scene)
    if Effect.CONTACT in effects:
        _put(contents, scene, used, laws, groups_of(contents.rapier, scene))
    else:
        nobody = dict.fromkeys({body.material for body in scene.bodies}, contents.rapier.InteractionGroups.none())
        contents.unseen = lambda: _put(contents, scene, used, {}, nobody)


def _put(contents: Made, scene: Scene, used: Settings, laws: Mapping[frozenset[str], Law], groups: Mapping[str, Any]) -> None:
    """The shapes of all bodies. Args: laws: by pair of materials. groups: by material, whom it meets."""
    rapier, world = contents.rapier, contents.world
    alike = len(set(laws.values())) <= 1
    friction, restitution = next(iter(laws.values()), (0.0, 0.0))
    materials: dict[int, str] = {}
    for body_index, (body, handle) in enumerate(zip(scene.bodies, contents.handles, strict=True)):
        for collider in colliders_of(rapier, body, used.options["inner_edges"]):
            builder = collider.friction(friction).restitution(restitution)
            if body.material in groups:
                builder = builder.collision_groups(groups[body.material])
            if not alike:
                builder = builder.active_hooks(rapier.ActiveHooks.MODIFY_SOLVER_CONTACTS)
            index = world.add_collider(builder, handle).index
            contents.owners[index], materials[index] = body_index, body.material
    if not alike:
        world.physics_hooks = PairLaws(laws, materials, rapier.SolverFlags.COMPUTE_IMPULSES)
