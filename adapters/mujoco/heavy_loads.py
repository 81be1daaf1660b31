"""How firm contacts are where one body may bear another that is many times heavier: by the masses of a scene."""

from plumbline.adapters.mujoco.options import Options
from plumbline.adapters.mujoco.softness import time_constant
from plumbline.harness.adapter.touching_kinds import Kind, touching_kinds
from plumbline.harness.scene import Scene
from plumbline.harness.scene.shape import width

FIRM = 0.999
"""Impedance of contacts on tuned: what rests sinks by micrometres."""
FIRMEST = 0.9999
"""The greatest impedance that the engine takes (mjMAXIMP)."""
DEEP = 0.01
"""Share of the least half width of a scene's bodies that a contact may give way by under a load, before it is made firmer."""


def impedance_for(scene: Scene, options: Options, h: float) -> float:
    """The impedance of contacts in a scene that is stepped by h [s]: the firmest where the usual one would sink deep.

    At constant impedance d a contact of time constant tc and damping ratio z gives way by (1 - d) a (tc z)^2, where a is what
    its load accelerates its bodies by: (1 + M/m) g, where a body of mass m bears one of mass M at one point. Source: MuJoCo,
    "Modeling", solver parameters (penetration at rest).
    """
    g = sum(c * c for c in scene.gravity) ** 0.5
    constant = time_constant(options.contact_steps, h, options.slowest) * (options.contact_damping_ratio or 1.0)
    masses: dict[Kind, list[float]] = {}
    for body in scene.bodies:
        if body.movable and body.collision:
            masses.setdefault((body.material, True), []).append(body.mass)
    ratio = max(
        (
            max(max(masses[a]) / min(masses[b]), max(masses[b]) / min(masses[a]))
            for a, b in touching_kinds(scene)
            if a in masses and b in masses
        ),
        default=1.0,
    )
    thin = min((width(p.shape) for body in scene.bodies if body.movable for p in body.collision), default=0.0) / 2
    return FIRMEST if (1 - FIRM) * (1 + ratio) * g * constant**2 > DEEP * thin else FIRM
