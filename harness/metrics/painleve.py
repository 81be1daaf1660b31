"""Painleve's coefficient: what multiplies the load on the foot of a sliding rod in the law of its normal acceleration.

A = 1 + (m/I) c (c - mu h), c and h the ways of the centre of mass from the foot along and above the ground. Positive: Coulomb's
law has one solution. Negative: it has none or two, which is the regime of the paradox.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Sphere
from plumbline.harness.trajectory.kinematics import rotate


@metric("1", better="higher")
def painleve_coefficient(run: Run) -> float:
    """Genot, Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653, with a rounded foot: least value over the run; below 0 Coulomb's
    law and rigidity contradict each other"""
    bodies = run.movable
    if len(bodies) != 1 or len(run.actual) == 0:
        raise NotMeasurable("one movable body, and a sample of it, is needed")
    rod = run.scene.bodies[bodies[0]]
    feet = [placed for placed in rod.collision if isinstance(placed.shape, Sphere)]
    grounds = [body for body in run.scene.bodies if run.scene.collides(rod, body)]
    if len(feet) != 2 or len(feet) != len(rod.collision) or len(grounds) != 1:
        raise NotMeasurable(f"body '{rod.name}' is no rod with two round ends on one ground")
    friction = run.scene.surface(rod, grounds[0]).kinetic_friction
    smallest = np.inf
    for foot in feet:
        arm = -rotate(run.actual.q_WB[:, bodies[0]], np.broadcast_to(foot.p_BS, (len(run.actual), 3)))
        along, above = np.hypot(arm[:, 0], arm[:, 1]), arm[:, 2] + getattr(foot.shape, "radius", 0.0)
        inertia = float(np.linalg.eigvalsh(np.array(rod.inertia))[-1])
        coefficient = 1 + rod.mass / inertia * along * (along - friction * above)
        # The end that is up has its arm downwards, and a coefficient that is never small.
        smallest = np.minimum(smallest, np.min(coefficient))
    return float(smallest)
