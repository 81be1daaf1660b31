"""A scene becomes a world of Bullet: everything in its order."""

from collections.abc import Container, Mapping
from itertools import combinations, product
from typing import Any

import numpy as np

from plumbline.adapters.bullet.bodies import check_joined, put_free, put_static, renew_inertia
from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.adapters.bullet.closures import close_loop, couple
from plumbline.adapters.bullet.coordinates import maximal
from plumbline.adapters.bullet.ground import faced
from plumbline.adapters.bullet.multibodies import put_multibody
from plumbline.adapters.bullet.options import resolved_settings, set_parameters
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.shapes import check_pairs, check_shapes, unseen_shape
from plumbline.adapters.bullet.simulation import BulletSimulation
from plumbline.adapters.bullet.trees import constrained_joints, spanning_trees
from plumbline.adapters.bullet.vendor import Port
from plumbline.harness.adapter import Notice, Settings, Unsupported
from plumbline.harness.adapter.carried_laws import carried, refuse_tendons
from plumbline.harness.adapter.fast_rotors import rotor_notices
from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.adapter.rotors import Blows
from plumbline.harness.scene import WORLD, Body, Distance, Effect, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import State


def build_world(port: Port, scene: Scene, settings: Settings, options: Mapping[str, Any]) -> BulletSimulation:
    """Exactly this scene in an empty world; the initial state is read back at the end. Raises: Unsupported, SettingsError."""
    plan = Plan.of(scene, settings, options)
    if Effect.JOINTS in scene.effects:
        refuse_tendons(scene)
    made = Assembly(port, unseen_shape(port), np.array([conjugate(q) for _, q in plan.principal]))
    _check(plan)
    set_parameters(port, settings, plan.options, plan.touching)
    constrained = constrained_joints(scene, plan.joints, options["joints"])
    made.notices += rotor_notices(scene, plan.joints, constrained, plan.h)
    acting = _put_bodies(plan, made, constrained)
    port.call("setGravity", *plan.gravity)
    _filter(plan, made)
    _surplus(plan, made)
    made.springs = plan.springs
    if any("armature" in carried(joint) for joint in plan.joints):
        made.blows = Blows(scene)
    simulation = BulletSimulation(scene, resolved_settings(port, settings, {**plan.options, **acting}), made)
    _verify(plan, made, simulation)
    return simulation


def _check(plan: Plan) -> None:
    """Refuse shapes and joints that Bullet has nothing for. Raises: Unsupported."""
    for body in plan.scene.bodies:
        check_shapes(body)
    if Effect.CONTACT in plan.effects:
        check_pairs(plan.scene)
    for joint in plan.joints:
        if isinstance(joint, Distance):
            raise Unsupported(
                f"distance joint '{joint.name}'", "Bullet has no constraint that keeps or bounds the distance of two points"
            )


def _put_bodies(plan: Plan, made: Assembly, constrained: Container[str]) -> dict[str, Any]:
    """Bodies in maximal coordinates first, then what stands still, bodies in multibody coordinates, trees and constraints.

    Returns: the options that are known by now: the coordinates that bodies are in, and whether a cone bounds their friction,
    which it does where one body of each pair is in multibody coordinates.
    """
    bodies = plan.scene.bodies
    trees = spanning_trees(plan.scene, plan.joints, constrained)
    held = {name for joint in plan.joints if joint.name in constrained for name in (joint.parent, joint.child)}
    single = [tree.base for tree in trees if tree.base is not None and not tree.links]
    free = [place for place in single if bodies[place].name not in held]
    loose = sorted(place for place in free if maximal(plan, place))
    for place in loose:
        put_free(plan, made, place, maximal=True)
    renew_inertia(plan, made)
    for place, body in enumerate(bodies):
        if body.motion == "static":
            put_static(plan, made, place, maximal=bool(loose))
    # pybullet ties bodies in maximal coordinates to nothing but each other, so what a constraint holds is a multibody.
    for place in sorted(set(single) - set(loose)):
        if bodies[place].name in held:
            check_joined(plan, made, place)
        put_free(plan, made, place, maximal=False)
    for tree in trees:
        if tree.links:
            put_multibody(plan, made, tree)
    for tree in trees:
        for joint in tree.closures:
            close_loop(plan, made, joint)
    for joint in plan.joints:
        if isinstance(joint, Revolute | Prismatic) and joint.coupling is not None:
            couple(made, joint.name, joint.coupling)
    reduced = bool(made.linked) or len(loose) < len(made.bases)
    apart = any(bodies[place].motion == "dynamic" and plan.coefficients(bodies[place]).friction > 0 for place in loose)
    return {
        "coordinates": "both" if loose and reduced else "maximal" if loose else "multibody",
        "cone_friction": plan.options["cone_friction"] and not apart and plan.settings.solver in (None, "si"),
    }


def _filter(plan: Plan, made: Assembly) -> None:
    """Keep joined bodies, materials that are apart, and prescribed bodies and what stands still, from colliding.

    And of a plane and the box in its place each from what the other is there for.
    """
    if not plan.solid:
        return
    by_name: dict[str, list[tuple[int, int]]] = {}
    for key, place in made.address.items():
        by_name.setdefault(plan.scene.bodies[place].name, []).append(key)
    apart = {tuple(sorted(pair)) for pair in plan.scene.joined() if WORLD not in pair}
    still = [b.name for b in plan.scene.bodies if b.motion != "dynamic"]
    prescribed = [b.name for b in plan.scene.bodies if b.motion == "kinematic"]
    apart |= {tuple(sorted((a, b))) for a in prescribed for b in still if a != b}
    solid: dict[str, list[Body]] = {}
    for body in plan.scene.bodies:
        if body.collision:
            solid.setdefault(body.material, []).append(body)
    for material, other in plan.scene.apart:
        mine, others = solid.get(material, []), solid.get(other, [])
        pairs = combinations(mine, 2) if material == other else product(mine, others)
        apart |= {(a.name, b.name) if a.name < b.name else (b.name, a.name) for a, b in pairs if a.movable or b.movable}
    for a, b in sorted(apart):
        for (first, i), (second, j) in product(by_name.get(a, ()), by_name.get(b, ())):
            made.port.call("setCollisionFilterPair", first, second, i, j, 0)
    for (ground, faces), ((number, link), place) in product(made.grounds, made.address.items()):
        if plan.scene.bodies[place].movable and faced(plan.scene.bodies[place]) is not faces:
            made.port.call("setCollisionFilterPair", ground, number, -1, link, 0)


def _surplus(plan: Plan, made: Assembly) -> None:
    """Name what is computed although the scene does not call for it, and what is not although it does."""
    if Effect.CONTINUOUS_COLLISION in plan.effects and not plan.swept:
        text = "continuous collision: multibodies, pybullet's default, cannot be swept"
        made.notices.append(Notice(text, "missing", Effect.CONTINUOUS_COLLISION))
    movable = [k for k, body in enumerate(plan.scene.bodies) if body.movable]
    uneven = any(max(plan.principal[k][0]) > min(plan.principal[k][0]) * (1 + 1e-12) for k in movable)
    if Effect.GYROSCOPIC not in plan.effects and uneven:
        made.notices.append(Notice("gyroscopic terms, for which pybullet offers no switch", "surplus", Effect.GYROSCOPIC))
    if plan.options["damping"] == "vendor":
        for effect, damping in ((Effect.LINEAR_DAMPING, "linear damping"), (Effect.ANGULAR_DAMPING, "angular damping")):
            if effect not in plan.effects and movable:
                text = f"{damping}, by the vendor's default of 0.04 on bodies of which the scene says 0"
                made.notices.append(Notice(text, "surplus", effect))


def _verify(plan: Plan, made: Assembly, simulation: BulletSimulation) -> None:
    """Do the joint rates give the velocities that the scene says? Raises: Unsupported."""
    if not made.linked:
        return
    got, wanted = State.empty(len(plan.scene.bodies)), State.initial(plan.scene)
    simulation.state(got)
    for name in ("p_WB", "v_WB", "w_WB"):
        miss = np.abs(getattr(got, name) - getattr(wanted, name)).max(axis=1)
        worst = int(miss.argmax())
        if miss[worst] > 1e-7 * (1 + np.abs(getattr(wanted, name)).max()):
            raise Unsupported(
                f"{name} of body '{plan.scene.bodies[worst].name}'",
                f"misses what its joints allow by {miss[worst]:.3g}; Bullet's multibodies have no other motion",
            )
