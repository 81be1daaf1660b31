"""Bodies in the engine's words."""

from typing import TYPE_CHECKING

import numpy as np

from plumbline.adapters.reference.shapes import engine_shape
from plumbline.harness.scene import Body, Effect

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["engine_body"]


def engine_body(body: Body, effects: Effect) -> "engine.Body":
    """A body without the damping that the scene leaves out."""
    from plumbline import engine

    v_WB, w_WB = body.velocity_at_start
    inertia = np.array(body.inertia)
    return engine.Body(
        name=body.name,
        mass=body.mass,
        inertia=(inertia + inertia.T) / 2,  # that of a scene may be off by a rounding
        shapes=tuple(engine_shape(placed) for placed in body.collision),
        visual=None if body.visual is None else tuple(engine_shape(placed) for placed in body.visual),
        material=body.material,
        optics=engine.Optics(
            colour=body.appearance.colour,
            mirror=body.appearance.mirror,
            transmission=body.appearance.transmission,
            refractive_index=body.appearance.refractive_index,
        ),
        p_WB=body.p_WB,
        q_WB=body.q_WB,
        v_WB=v_WB,
        w_WB=w_WB,
        motion=body.motion,
        linear_damping=body.linear_damping if Effect.LINEAR_DAMPING in effects else 0.0,
        angular_damping=body.angular_damping if Effect.ANGULAR_DAMPING in effects else 0.0,
    )
