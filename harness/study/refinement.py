"""How far a ladder of time steps goes on below the steps that an experiment names, and what is run where that tells no more."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.scene.values import FROZEN


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Refinement:
    """See `harness.search.refined_ladder`.

    Terms:
        finest [s]: the time step that every engine's ladder is halved down to. further: halvings beyond it, for an engine whose
        limit is not known to the end yet. budget [s]: CPU time of all runs of the experiment, shared alike by its engines and
        tracks. members: perturbed starts that are run where no two engines' limits are known to the end, at the time step
        `member_dt` [s].
    """

    finest: Annotated[float, Field(ge=1e-12, le=1e3, allow_inf_nan=False)] = 1 / 3840
    further: Annotated[int, Field(ge=0, le=10)] = 2
    budget: Annotated[float, Field(ge=0, le=1e7)] = 120.0
    members: Annotated[int, Field(ge=0, le=1000)] = 8
    member_dt: Annotated[float, Field(ge=1e-12, le=1e3, allow_inf_nan=False)] = 1 / 960
