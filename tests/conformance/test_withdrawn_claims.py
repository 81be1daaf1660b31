"""Claims about limits that docs/fairness.md lists as withdrawn: what was said to break holds, for all starts."""

import numpy as np
import pytest

from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment, Limit
from plumbline.harness.study.study import Study
from plumbline.harness.trial.ensemble import endure
from tests.conformance.engines import adapter, why_unavailable

STEP = 1 / 240


@pytest.mark.parametrize(
    ("case", "engine", "parameters", "dt"),
    [
        ("spin_heavy_top", "bullet", {"spin": 100.0}, STEP),
        ("spin_heavy_top", "bullet", {"spin": 800.0}, STEP),
        ("spin_heavy_top", "dart", {"spin": 100.0}, STEP),
        ("stack_tower", "bullet", {"n": 1}, 1 / 15),
        ("stack_tower", "bullet", {"n": 4}, 1 / 15),
        ("stack_card_house", "bullet", {"margin": 0.2}, STEP),
        ("stack_card_house", "mujoco", {"margin": 0.2}, STEP),
        ("stack_card_house", "dart", {"margin": 0.2}, STEP),
        ("tunnel_rod", "mujoco", {"spin": 11.0, "continuous": False}, STEP),
        ("tunnel_sphere_wall", "mujoco", {"speed": 12.0, "continuous": False}, STEP),
        ("tunnel_sphere_wall", "dart", {"speed": 10.0, "continuous": False}, STEP),
    ],
)
def test_what_was_said_to_break_holds_in_one_step(case: str, engine: str, parameters: dict[str, float], dt: float) -> None:
    """On the tuned track, in one sub-step a time step, as the limits study asks."""
    if reason := why_unavailable(engine):
        pytest.skip(reason)
    experiment = Experiment(
        name="axis",
        cases=(case,),
        tracks=("tuned",),
        dt=(dt,),
        parameters={name: (value,) for name, value in parameters.items()},
        timing=False,
        limit=Limit(parts=(1,), members=4),
    )
    study, asked = Study(name="limits", experiments=(experiment,)), plugins.case(case)
    (start,) = study.trials({case: asked}, {engine: adapter(engine)}, {engine: "1"})
    trial = start.probing(asked, parameters={**start.parameters, **parameters})
    with np.errstate(all="ignore"):
        record = endure(trial, asked, adapter(engine), None)
    assert record.status == "passed", record.reason
