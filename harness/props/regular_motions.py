"""A scene with one of each regular motion: a spin, a swing, a slide and a roll. What tells its retellings apart is an engine's.

Nothing in it is chaotic: a difference of a rounding grows with time, and at most with its square.
"""

import math

from plumbline.harness.scene import Body, Box, Revolute, Scene, Surface, principal_inertia

FRICTION, MASS = 0.4, 1.0
HALF, RADIUS, LENGTH = (0.1, 0.1, 0.05), 0.1, 0.5
AMPLITUDE, HEIGHT = 40.0, 1.0
"""Degrees from hanging, and the height [m] of the hinge."""
FLOOR = (5.0, 5.0, 0.5)
DEPTH = 1e-6
"""How deep [m] box and ball stand in the floor: if they just touched, a rounding would decide if the first step sees it."""


def stage() -> Scene:
    """A box that slides to a stop, a ball that slips until it rolls, a rod that swings, and a body that tumbles as it falls.

    The rod hangs on the floor's body, not on the world, so that all of it can be set in motion.
    """
    floor = Body.fixed("floor", Box(half_extents=FLOOR), material="floor", p_WB=(0.0, 0.0, -FLOOR[2]))
    box = Body.box("box", HALF, mass=MASS, material="mover", p_WB=(0.0, 0.0, HALF[2] - DEPTH), v_WB=(1.6, 1.2, 0.0))
    ball = Body.ball("ball", RADIUS, mass=MASS, material="mover", p_WB=(-2.0, 0.0, RADIUS - DEPTH), v_WB=(0.6, -0.8, 0.0))
    theta = math.radians(AMPLITUDE)
    half = (0.02, 0.02, LENGTH / 2)
    rod = Body.box(
        "rod",
        half,
        mass=MASS,
        touches=False,
        p_WB=(LENGTH / 2 * math.sin(theta), 2.0, HEIGHT - LENGTH / 2 * math.cos(theta)),
        q_WB=(math.cos(theta / 2), 0.0, -math.sin(theta / 2), 0.0),
    )
    top = Body(
        name="top",
        mass=MASS,
        inertia=principal_inertia(0.01, 0.02, 0.025),
        p_WB=(0.0, -2.0, 1.0),
        v_WB=(0.5, 0.0, 3.0),
        w_WB=(1.0, 3.0, 2.0),
    )
    hinge = Revolute(name="hinge", parent="floor", child="rod", anchor_W=(0.0, 2.0, HEIGHT), axis_W=(0.0, 1.0, 0.0))
    return Scene(
        bodies=(floor, box, ball, rod, top),
        joints=(hinge,),
        surfaces=(Surface.rough(FRICTION, ("floor", "mover")),),
        apart=(("mover", "mover"),),
    )
