"""A scene becomes a world of SAPIEN: everything in its order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbline.adapters.sapien.bodies import Bodies, check_body, slab_of
from plumbline.adapters.sapien.joints import Articulated, constrain, holder
from plumbline.adapters.sapien.options import resolved_settings
from plumbline.adapters.sapien.simulation import SapienSimulation, World
from plumbline.adapters.sapien.surfaces import groups_of, materials_of, patches_of
from plumbline.adapters.sapien.vendor import new_world
from plumbline.harness.adapter import Notice, Settings, Unsupported
from plumbline.harness.adapter.carried_laws import refuse_tendons
from plumbline.harness.adapter.distance_springs import DistanceSprings, is_distance_spring
from plumbline.harness.adapter.reduced_trees import JointTree, trees_of
from plumbline.harness.scene import WORLD, Effect, Joint, Plane, Scene

IGNORED = 32
"""Bits by which shapes of one group ignore each other."""


def build(sapien: Any, scene: Scene, settings: Settings) -> SapienSimulation:
    """Exactly this scene under these settings. Raises: Unsupported, SettingsError."""
    effects = scene.effects
    joints = tuple(j for j in scene.joints if not is_distance_spring(j)) if Effect.JOINTS in effects else ()
    if Effect.JOINTS in effects:
        refuse_tendons(scene)
    trees = trees_of(scene, joints)
    reduced = {branch.edge.name for tree in trees for branch in tree.branches}
    loose = [joint for joint in joints if joint.name not in reduced]
    used = resolved_settings(settings, scene, bool(loose), trees)
    towed = next((joint for joint in loose if _holds_led(scene, joint)), None)
    if towed is not None and used.solver == "pgs":
        raise Unsupported(
            f"joint '{towed.name}': a body that is led", "PGS takes its turning for nought at joints; TGS does not"
        )
    patches = patches_of(scene)
    if any(patches.values()) and used.solver == "pgs":
        raise Unsupported("torsional friction", "patches of contact brake a spin under TGS, and under PGS they do not")
    for body in scene.bodies:
        check_body(body)
    gravity = scene.gravity if Effect.GRAVITY in effects else (0.0, 0.0, 0.0)
    world = World(sapien, *new_world(sapien, gravity, used))
    if Effect.JOINTS in effects:
        world.springs = DistanceSprings.of(scene, scene.joints, used.substep)
    bodies = Bodies(sapien, effects, used, materials_of(sapien, scene), groups_of(scene), patches, slab_of(scene))
    _Builder(world, scene, bodies, trees).build(loose, used.options["capped"])
    if Effect.CONTACT not in effects:
        world.shape = lambda: bodies.shape_for_rays(scene, world.components)
    _notice(world, scene, effects, used, bool(trees))
    if bodies.slab and any(isinstance(placed.shape, Plane) for body in scene.bodies for placed in body.collision):
        world.notices.append(
            Notice(f"a box of {2 * bodies.slab:.4g} m stands for each plane: meshes that move fall through planes")
        )
    return SapienSimulation(scene, used, world)


def _holds_led(scene: Scene, joint: Joint) -> bool:
    """Does a joint hold something on a body that is led?"""
    return any(name != WORLD and scene.body(name).motion == "kinematic" for name in (joint.parent, joint.child))


@dataclass(slots=True)
class _Builder:
    """Puts bodies and joints into a world."""

    world: World
    scene: Scene
    bodies: Bodies
    trees: list[JointTree]
    names: dict[str, Any] = field(default_factory=dict)
    ignored: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def build(self, loose: Sequence[Joint], capped: bool) -> None:
        """Trees, then bodies outside of them, then the joints outside of them. Raises: Unsupported."""
        world, scene = self.world, self.scene
        self.ignored = self._ignored()
        articulated = Articulated(world.sapien, scene, capped, self._link)
        for tree in self.trees:
            self.names |= articulated.put(world.scene, tree)
        world.driven = articulated.driven
        entities = {}
        for number, body in enumerate(scene.bodies):
            if body.name in self.names:
                continue
            physx = world.sapien.physx
            component = physx.PhysxRigidStaticComponent() if body.motion == "static" else physx.PhysxRigidDynamicComponent()
            entities[body.name] = self.bodies.entity(body, component, number, self.ignored.get(body.name, (0, 0)))
            if body.motion != "static":
                self.bodies.tell_mass(body, component)
                component.kinematic = body.motion == "kinematic"
            self.names[body.name] = component
        for joint in loose:
            name = holder(scene, joint)
            entity = entities.get(name) or self.names[name].entity
            for component in constrain(world.sapien, scene, joint, self.names, self.names[name]):
                entity.add_component(component)
        for name, entity in entities.items():
            world.scene.add_entity(entity)
            body = scene.body(name)
            if body.movable:
                # What single precision has not becomes infinite, and is told in the first step.
                with np.errstate(over="ignore"):
                    self.names[name].set_linear_velocity(list(body.v_WB))
                    self.names[name].set_angular_velocity(list(body.w_WB))
        world.components = {scene.index(name): component for name, component in self.names.items()}

    def _ignored(self) -> dict[str, tuple[int, int]]:
        """What of a body that stands still and those that hang on it keeps them from touching: bits, and their group.

        Raises: Unsupported.
        """
        ignored: dict[str, tuple[int, int]] = {}
        for group, tree in enumerate((tree for tree in self.trees if tree.root != WORLD), 1):
            if self.scene.body(tree.root).motion != "static":
                continue
            hanging = [branch.node for branch in tree.branches if branch.above == tree.root]
            if len(hanging) > IGNORED:
                raise Unsupported(
                    f"{len(hanging)} bodies joined to '{tree.root}'", f"SAPIEN has {IGNORED} bits of ignored contact"
                )
            ignored[tree.root] = (1 << len(hanging)) - 1, group
            ignored |= {name: (1 << k, group) for k, name in enumerate(hanging)}
        return ignored

    def _link(self, name: str, component: Any) -> Any:
        body = self.scene.body(name)
        entity = self.bodies.entity(body, component, self.scene.index(name), self.ignored.get(name, (0, 0)))
        self.bodies.tell_mass(body, component)
        return entity


def _notice(world: World, scene: Scene, effects: Effect, used: Settings, reduced: bool) -> None:
    """Name what is computed although the scene does not call for it, and what is not although it does."""
    movable = [body for body in scene.bodies if body.movable]
    if Effect.CONTINUOUS_COLLISION in effects:
        text = "continuous collision: SAPIEN 3.0.3 switches it on for the scene and for no body of it"
        world.notices.append(Notice(text, "missing", Effect.CONTINUOUS_COLLISION))
    uneven = any(body.inertia[0][0] != body.inertia[1][1] or body.inertia[1][1] != body.inertia[2][2] for body in movable)
    if Effect.GYROSCOPIC not in effects and uneven:
        world.notices.append(Notice("gyroscopic terms, for which SAPIEN offers no switch", "surplus", Effect.GYROSCOPIC))
    if used.options["damping"] == "vendor" and Effect.ANGULAR_DAMPING not in effects and movable:
        text = "angular damping, by the vendor's default on bodies of which the scene says 0"
        world.notices.append(Notice(text, "surplus", Effect.ANGULAR_DAMPING))
        if Effect.LINEAR_DAMPING not in effects and reduced:
            text = "linear damping, by the vendor's default on bodies that hinges, slides and welds hold"
            world.notices.append(Notice(text, "surplus", Effect.LINEAR_DAMPING))
