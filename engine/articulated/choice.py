"""Whether a world is solved in joint coordinates: as its options choose, where its joints make trees and nothing can touch."""

from collections.abc import Sequence

from engine.articulated.forest import Forest, NoForest, forest_of
from engine.describe.bodies import Body
from engine.describe.errors import NotSupported
from engine.describe.joints import Joint
from engine.options import ADAPTIVE, JOINT, MAXIMAL, Options

__all__ = ["chosen_forest"]

INTEGRATORS = ("semi_implicit_euler", "rk4", "implicit_midpoint", ADAPTIVE)
"""Those that know joint coordinates."""


def chosen_forest(bodies: Sequence[Body], joints: Sequence[Joint], options: Options, touching: bool) -> Forest | None:
    """The trees that a world is solved as; None where its bodies keep their own coordinates, as all do without joints.

    Args: touching: whether two bodies may touch.
    Raises: NotSupported where joint coordinates are asked for, and nothing else will do.
    """
    if options.used_coordinates == MAXIMAL or not joints:
        return None
    forest: Forest | NoForest = NoForest("contacts", "contacts are solved between bodies with coordinates of their own")
    if options.integrator not in INTEGRATORS:
        forest = NoForest(f"the integrator '{options.integrator}'", f"they know {', '.join(INTEGRATORS)}")
    elif not touching:
        forest = forest_of(bodies, joints)
    if isinstance(forest, Forest):
        return forest
    if options.coordinates == JOINT:
        raise NotSupported(f"joint coordinates with {forest.what}", forest.why)
    return None
