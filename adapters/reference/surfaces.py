"""Laws of contact in the engine's words."""

from typing import TYPE_CHECKING

from plumbline.harness.scene import Effect, Surface

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["engine_surface"]


def engine_surface(law: Surface, effects: Effect) -> "engine.Surface":
    """A law without what the scene leaves out."""
    from plumbline import engine

    rubs = Effect.FRICTION in effects
    return engine.Surface(
        static_friction=law.static_friction if rubs else 0.0,
        kinetic_friction=law.kinetic_friction if rubs else 0.0,
        restitution=law.restitution if Effect.RESTITUTION in effects else 0.0,
        rolling_friction=law.rolling_friction if Effect.ROLLING_FRICTION in effects else 0.0,
        torsional_friction=law.torsional_friction if Effect.TORSIONAL_FRICTION in effects else 0.0,
    )
