"""Semi-implicit Euler in joint coordinates: q'' from the forces now, springs and limits at the end, then q' and then q.

    q' <- q' + h q'',  q <- q + h q'   (orientations: q <- exp(h w) q)

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, section 3.2 (equation of motion); Hairer, Lubich, Wanner, Geometric
Numerical Integration, section I.1.2.
"""

from engine.articulated.advance import add_reactions, change_rates, drift_coordinates
from engine.articulated.bounded import solve_laws
from engine.articulated.laws import ALL
from engine.articulated.motion import move_links
from engine.articulated.tables import Tables
from engine.compile.jit import kernel
from engine.maths.vec import Floats
from engine.memory.tables import Bodies, Joints

__all__ = ["semi_implicit_euler"]


@kernel
def semi_implicit_euler(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, reactions: bool
) -> bool:
    """Advance all trees by h. Args: reactions: whether to count what joints carry. Returns: whether the laws had an answer."""
    move_links(tables, bodies.state)
    if not solve_laws(tables, bodies, joints, setting, h, gyroscopic, ALL):
        return False
    if reactions:
        add_reactions(tables, joints, h)
    change_rates(tables, h)
    drift_coordinates(tables, h)
    return True
