"""Why an engine that others are compared with errs least in a case."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Advantage:
    """Why an engine errs least in a case: what it is given, and not what it is.

    Terms:
        by: sub-steps, where it takes several to the others' one; the order of its integrator; construction, where its method
        keeps or has in it what the truth says; its own law, where others have none; a solver, where another method solves the
        same equations; defaults, where the others' own ones, or their adapters', add what the scene does not ask for. why: as a
        sentence without its full stop, with the figures.
    """

    by: Literal["sub-steps", "order", "construction", "own law", "solver", "defaults"]
    why: str
