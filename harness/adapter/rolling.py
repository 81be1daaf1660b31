"""Balls alone: where none touches another one, friction is rigid if MuJoCo's slip correction has it for itself."""

import itertools

from plumbline.harness.scene import Effect, Scene, Sphere

CORRECTIONS = 5
"""Of the slip (noslip_iterations), in such scenes. A ball has one contact, so that one of them is exact."""


def balls_alone(scene: Scene) -> bool:
    """Do balls alone move freely, which rub and neither rebound nor touch each other?"""
    effects = scene.effects
    if scene.joints or Effect.CONTACT | Effect.FRICTION not in effects or Effect.RESTITUTION in effects:
        return False
    moving = [body for body in scene.bodies if body.movable]
    if any(len(body.collision) != 1 or not isinstance(body.collision[0].shape, Sphere) for body in moving):
        return False
    return not any(scene.collides(a, b) for a, b in itertools.combinations(moving, 2))
