"""Rotors in joints: implicit dampers of DART that brake nothing."""

from typing import Any

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.vendor import body_of
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.rotors import Blows


class Rotors:
    """The rotors of a world.

    DART takes a damper c implicitly: it solves (M + h c) v' = M v + h f - ... with the force -c v' of the step's end. A damper
    of armature/h adds the armature to M, and the force (armature/h) v, which is told for the step, takes back what it brakes:
    M q'' = f - (armature/h) (v' - v) = f - armature q''.
    """

    def __init__(self, built: Built) -> None:
        """Raises: Unsupported, where impulses act beside rotors at all times."""
        self._built, self._blows = built, Blows(built.scene)
        groups: dict[int, tuple[Any, list[tuple[int, float]]]] = {}
        for name, rate in built.rotors.items():
            joint = built.coordinates[name]
            if joint.getActuatorType() != built.dart.dynamics.ActuatorType.FORCE:
                raise Unsupported(f"joint '{name}': armature", "DART's own servo moves its joint by impulses")
            skeleton = joint.getSkeleton()
            _, places = groups.setdefault(id(skeleton), (skeleton, []))
            places.append((int(joint.getIndexInSkeleton(0)), rate))
        self._skeletons = [
            (skeleton, [k for k, _ in some], np.array([c for _, c in some])) for skeleton, some in groups.values()
        ]

    def lead(self) -> None:
        """Tell the forces of the coming step that take back what the dampers brake, where nothing else is told."""
        for skeleton, places, rates in self._skeletons:
            skeleton.setCommands(places, rates * skeleton.getVelocities()[places])

    def check(self) -> None:
        """Has nothing struck a tree with rotors in the last step? Raises: Unsupported."""
        built = self._built
        result = built.world.getLastCollisionResult()
        touching: set[int] = set()
        if result.getNumContacts():
            touching = {body_of(c) for each in result.getContacts() for c in (each.collisionObject1, each.collisionObject2)}
        self._blows.check(lambda name: float(built.coordinates[name].getPosition(0)), touching)
