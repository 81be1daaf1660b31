"""A study of engines whose price of an error is known exactly, carried out for real: what a table of prices is measured by.

The engines are `spinner` and `laggard` of `tests/unit/plugins`: error = coefficient dt^order, and a step costs `spin` of CPU
time. An error e is reached at dt = (e / coefficient)^(1/order), and a simulated second then costs spin / dt.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from plumbline.harness.run.campaign import carry_out
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment, Variant
from plumbline.harness.study.study import Study
from tests.in_process import in_this_process

__all__ = ["CASE", "LADDER", "LAWS", "PLUGINS", "KnownPrices", "Law", "run_known_prices"]

PLUGINS = Path(__file__).parent / "unit" / "plugins"
"""A folder with an installed-looking plug-in."""
CASE = "flight_projectile"
LADDER = (1 / 60, 1 / 120, 1 / 240, 1 / 480)


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """What an engine errs and costs. Terms: error 0.02 m at dt = 1/60 s, shrinking with `order`; spin [s] a step."""

    order: int
    spin: float

    def error(self, dt: float) -> float:
        """The headline error [m] at a time step dt [s]."""
        return 0.02 * (60.0 * dt) ** self.order

    def step(self, error: float) -> float:
        """The time step [s] at which the headline error is `error` [m]."""
        return float((error / 0.02) ** (1 / self.order)) / 60.0

    def cost(self, dt: float) -> float:
        """CPU seconds per simulated second at a time step dt [s]."""
        return self.spin / dt


LAWS: Mapping[tuple[str, str], Law] = {
    ("spinner", "default"): Law(order=1, spin=20e-6),
    ("spinner", "tuned"): Law(order=2, spin=20e-6),
    ("spinner", "fourth"): Law(order=4, spin=20e-6),
    ("laggard", "default"): Law(order=1, spin=60e-6),
    ("laggard", "tuned"): Law(order=2, spin=60e-6),
}
"""By engine and track or variant."""

STUDY = Study(
    name="known_prices",
    recordings=False,
    variants={"spinner": {"fourth": Variant(options={"order": 4, "coefficient": 0.02 * 60.0**4})}},
    experiments=(
        Experiment(
            name="flight",
            cases=(CASE,),
            variants=("*",),
            dt=LADDER,
            processes=2,
            samples=5,
            sample_seconds=0.01,
        ),
    ),
)


@dataclass(frozen=True, slots=True)
class KnownPrices:
    """A run folder and the laws, by engine and track, that its engines follow."""

    store: Store
    laws: Mapping[tuple[str, str], Law]

    def price(self, engine: str, error: float) -> float | None:
        """The least CPU seconds per simulated second for which an engine errs by `error` [m] or less; None where it never does.

        Between the steps that were run a law costs what it says; a coarser step than the coarsest was not run.
        """
        of_engine = (law for (name, _), law in self.laws.items() if name == engine)
        reached = (law for law in of_engine if law.error(min(LADDER)) <= error)
        return min((law.cost(min(law.step(error), max(LADDER))) for law in reached), default=None)


def run_known_prices(folder: Path) -> KnownPrices:
    """Carry the study out in `folder`: accuracy runs in this process, then timing runs in processes of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(PLUGINS)  # children inherit the path
        in_this_process(patch)
        engines = {name: plugins.adapter(name) for name in dict.fromkeys(engine for engine, _ in LAWS)}
        store = carry_out(STUDY, folder, {CASE: plugins.case(CASE)}, engines, workers=1, resume=False)
    return KnownPrices(store, LAWS)
