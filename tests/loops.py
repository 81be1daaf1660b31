"""Closed loops that several tests of the engine move."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline import engine

__all__ = ["bennett"]


def bennett(limits: engine.Limits | None, integrator: str, beside: Sequence[engine.Body] = ()) -> engine.World:
    """Four hinges in space, whose thirty rows for eighteen freedoms leave one: links a, b, a, b with twists alpha, beta.

    Source: Bennett, A new mechanism, Engineering 76, 1903: sin(alpha)/a = sin(beta)/b, tan(u/2) tan(v/2) =
    sin((beta + alpha)/2) / sin((beta - alpha)/2) for the angles u, v, 2 pi - u, 2 pi - v.
    """
    alpha, beta, a, u = 0.6, 1.2, 0.3, 1.1
    b = a * math.sin(beta) / math.sin(alpha)
    v = 2 * math.atan(math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2) / math.tan(u / 2))
    places, axes, turn, place = [], [], Rotation.identity(), np.zeros(3)
    for length, twist, angle in ((a, alpha, u), (b, beta, v), (a, alpha, -u), (b, beta, -v)):
        places.append(place)
        axes.append(turn.apply((0, 0, 1)))
        turn = turn * Rotation.from_euler("z", angle)
        place = place + turn.apply((length, 0, 0))
        turn = turn * Rotation.from_euler("x", twist)
    assert place == pytest.approx(np.zeros(3), abs=1e-12)
    assert turn.apply((0, 0, 1)) == pytest.approx(axes[0], abs=1e-12)
    names = [engine.WORLD, "one", "two", "three", engine.WORLD]
    bodies = [engine.Body(name=names[k], p_WB=(places[k - 1] + places[k]) / 2, inertia=0.02 * np.eye(3)) for k in (1, 2, 3)]
    joints = [
        engine.Revolute(name=f"pin{k}", parent=names[k], child=names[k + 1], anchor_W=places[k], axis_W=axes[k], limits=limits)
        for k in range(4)
    ]
    return engine.World([*bodies, *beside], joints, options=engine.Options(integrator=integrator, dt=1e-3))
