"""Whether a world is solved in joint coordinates: as its options choose, where its joints make trees.

Where joints close loops they are taken if they are asked for by name alone. Where bodies may touch they are taken unless most
bodies are loose: those have nothing of a tree, and a sweep over both costs more than over bodies alone. Coupled joints, tendons
and bodies without mass leave no choice: a row of bodies' own coordinates is between two bodies, both with mass.
"""

from collections.abc import Sequence

from plumbline.engine.articulated.forest import Forest, NoForest, forest_of, with_tendons
from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import Joint, Tendon
from plumbline.engine.options import ADAPTIVE, JOINT, MAXIMAL, Options

INTEGRATORS = ("semi_implicit_euler", "rk4", "implicit_midpoint", ADAPTIVE)
"""Those that know joint coordinates."""


def chosen_forest(
    bodies: Sequence[Body], joints: Sequence[Joint], options: Options, touching: bool, tendons: Sequence[Tendon] = ()
) -> Forest | None:
    """The trees that a world is solved as; None where its bodies keep their own coordinates, as all do without joints.

    Args: touching: whether two bodies may touch.
    Raises: NotSupported where joint coordinates are asked for, and nothing else will do.
    """
    wanted = [f"coupled joint '{joint.name}'" for joint in joints if getattr(joint, "coupling", None) is not None]
    wanted += [f"body '{body.name}' without mass" for body in bodies if body.massless]
    wanted += [f"tendon '{tendon.name}'" for tendon in tendons]
    if not wanted and (not joints or options.used_coordinates == MAXIMAL):
        return None
    if wanted and options.coordinates == MAXIMAL:
        raise NotSupported(f"{wanted[0]} with bodies' own coordinates", "a row of theirs is between two bodies, both with mass")
    found = forest_of(bodies, joints)
    if tendons and isinstance(found, Forest):
        found = with_tendons(found, joints, tendons)
    if options.coordinates != JOINT and not wanted and isinstance(found, Forest):
        loose = sum(bodies[i].motion == "dynamic" for i in found.others)
        if found.closing or (touching and loose > len(found.links)):
            return None
    if options.integrator not in INTEGRATORS:
        found = NoForest(f"the integrator '{options.integrator}'", f"they know {', '.join(INTEGRATORS)}")
    elif tendons and options.integrator != "semi_implicit_euler":
        found = NoForest(f"the integrator '{options.integrator}'", "semi_implicit_euler alone knows tendons")
    elif isinstance(found, Forest) and (touching or found.closing):
        found = unknown(options, "contacts" if touching else f"joint '{joints[found.closing[0]].name}'") or found
    if isinstance(found, Forest):
        return found
    if wanted:
        raise NotSupported(f"{wanted[0]} with {found.what}", found.why)
    if options.coordinates == JOINT:
        raise NotSupported(f"joint coordinates with {found.what}", found.why)
    return None


def unknown(options: Options, what: str) -> NoForest | None:
    """Why contacts, or loops, have no joint coordinates under these options; None where they have."""
    if options.integrator != "semi_implicit_euler":
        return NoForest(
            f"{what} under the integrator '{options.integrator}'", "semi_implicit_euler alone knows contacts and loops"
        )
    if options.solver != "tgs_soft":
        return NoForest(f"{what} under the solver '{options.solver}'", "the solver 'tgs_soft' alone knows trees")
    if options.continuous == "swept":
        return NoForest(f"{what} and swept collision", "a step in parts is known to bodies with coordinates of their own")
    if options.sleeping:
        return NoForest(f"{what} and sleep", "islands are known to bodies with coordinates of their own")
    return None
