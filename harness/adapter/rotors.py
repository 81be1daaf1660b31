"""Rotors of joints for engines that have none: a force beside the engine's own equations of motion, exact but for blows.

A rotor adds its armature to the diagonal of the mass matrix, M q'' + armature q'' = f. The adapter exerts -armature q'' on the
coordinate, q'' being that of the whole. The impulses of contacts, stops and dry friction an engine works out by M alone: it
answers a blow as if there were no rotor. A scene that has them all the time is refused; a run ends where it comes to one.
"""

import math
from collections.abc import Callable, Iterable

from plumbline.harness.adapter.carried_laws import carried
from plumbline.harness.adapter.contract import Unsupported
from plumbline.harness.adapter.distance_springs import is_distance_spring
from plumbline.harness.adapter.spanning_forest import DisjointSets
from plumbline.harness.scene import WORLD, Prismatic, Revolute, Scene

NEAR = 1e-4
"""How near [rad or m] to an end of its range a joint is taken to meet it: more than what an engine leaves of a stop."""
BY_IMPULSES = ("friction_loss", "speed_limit", "coupling")
"""Laws of a joint that engines keep by impulses."""
WHY = "the engine answers impulses as if no joint had a rotor; --drop armature leaves the rotors out"


class Blows:
    """What may strike the trees of joints that have rotors.

    Terms: bodies: the places of those that hang on such a tree. ranges [rad or m]: of its joints that have limits, by name.
    """

    def __init__(self, scene: Scene) -> None:
        """Raises: Unsupported, where a law of such a tree acts by impulses all the time."""
        trees, closed = DisjointSets[str](), DisjointSets[str]()
        joints = [joint for joint in scene.joints if not is_distance_spring(joint)]
        moving = {body.name for body in scene.bodies if body.motion != "static"}
        closing = set[str]()
        for joint in joints:
            ends = [name for name in (joint.parent, joint.child) if name in moving]
            if len(ends) == 2:
                trees.unite(*ends)
            if not closed.unite(*(name if name in moving else WORLD for name in (joint.parent, joint.child))):
                closing.add(joint.name)
        having = {trees.root(joint.child) for joint in joints if "armature" in carried(joint)}
        self.bodies = frozenset(k for k, b in enumerate(scene.bodies) if b.name in moving and trees.root(b.name) in having)
        self.ranges: dict[str, tuple[float, float]] = {}
        for joint in joints:
            if trees.root(joint.child) not in having:
                continue
            for law in BY_IMPULSES:
                if law in carried(joint):
                    raise Unsupported(f"joint '{joint.name}': {law.replace('_', ' ')} beside joints with rotors", WHY)
            if joint.name in closing:
                raise Unsupported(f"joint '{joint.name}', which closes a loop of joints with rotors", WHY)
            if isinstance(joint, Revolute | Prismatic) and joint.limits is not None:
                lower, upper = joint.limits.lower, joint.limits.upper
                self.ranges[joint.name] = (-math.inf if lower is None else lower, math.inf if upper is None else upper)

    def check(self, coordinate: Callable[[str], float], touching: Iterable[int]) -> None:
        """Has no joint met a stop, and no body of the trees touched anything?

        Args: coordinate: of a joint by its name [rad or m]. touching: the places of bodies that touch another one.
        Raises: Unsupported.
        """
        for name, (lower, upper) in self.ranges.items():
            if not lower + NEAR < coordinate(name) < upper - NEAR:
                raise Unsupported(f"joint '{name}' at the end of its range, beside joints with rotors", WHY)
        if not self.bodies.isdisjoint(touching):
            raise Unsupported("contact of bodies on joints with rotors", WHY)
