"""A scene becomes a world of the engine."""

from typing import TYPE_CHECKING

from plumbline.adapters.reference.bodies import engine_body
from plumbline.adapters.reference.joints import engine_joint, engine_tendon
from plumbline.adapters.reference.surfaces import engine_surface
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Effect, Scene

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["make_world"]


def make_world(scene: Scene, options: "engine.Options") -> "engine.World":
    """Exactly this scene. Raises: Unsupported."""
    from plumbline import engine

    effects = scene.effects
    joints = (engine_joint(joint, effects) for joint in scene.joints)
    tendons = (engine_tendon(tendon, effects) for tendon in scene.tendons or ())
    try:
        return engine.World(
            bodies=[engine_body(body, effects) for body in scene.bodies],
            joints=[*joints, *tendons] if Effect.JOINTS in effects else (),
            surfaces={law.between: engine_surface(law, effects) for law in scene.surfaces},
            gravity=scene.gravity if Effect.GRAVITY in effects else (0.0, 0.0, 0.0),
            options=options,
            apart=scene.apart,
            sun=engine.Sun(towards_W=scene.sun.towards_W, irradiance=scene.sun.irradiance, sky=scene.sun.sky),
        )
    except engine.NotSupported as error:
        raise Unsupported(error.what, error.why) from error
