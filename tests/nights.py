"""Nights carried out in this process, clocked by formula, with faults planted in an engine: what a history makes of them."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case, Converged, Problem
from plumbline.harness.findings.summary import write_summary
from plumbline.harness.history import night_policy
from plumbline.harness.history.changes_since import News
from plumbline.harness.history.folder import History, Night, created
from plumbline.harness.history.night import accounted, carry_out_night, close, compared, night_to_do
from plumbline.harness.history.night_policy import NightWish
from plumbline.harness.run import campaign
from plumbline.harness.scene import Scene
from plumbline.harness.store.record import Record
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Floats
from plumbline.harness.trial import accuracy, answer, ensemble
from plumbline.harness.trial.accuracy import judged_anew, run_trial
from plumbline.harness.trial.answer import RunAnswer
from plumbline.harness.trial.ensemble import endure
from plumbline.harness.trial.truth_cache import truth_of
from tests.in_process import clocked_by

__all__ = ["CELLS", "STUDY", "Fault", "asked", "drawn", "night", "planted", "rougher", "one_ulp_off"]

ENGINES = ("reference", "mujoco")
STUDY = Study(
    name="few",
    recordings=False,
    experiments=(
        Experiment(name="look", cases=("flight_projectile", "friction_stop"), samples=3),
        Experiment(name="ladder", cases=("flight_projectile",), dt=(1 / 60, 1 / 240), samples=3),
    ),
)
"""Two cases once and two steps, each on two tracks."""
CELLS = 16
"""Answers of it on both engines, each with its price."""
NOISE, SLOW = 0.01, 1.0
"""Of every price: how far samples stray, and times as dear on this machine."""


def _as_it_is(scene: Scene) -> Scene:
    return scene


def _untouched(_state: Any) -> None:
    pass


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """What is planted in an engine. Terms: scene, state: what becomes of them. price: times as dear. known: by its sources?"""

    engine: str
    scene: Callable[[Scene], Scene] = _as_it_is
    state: Callable[[Any], None] = _untouched
    price: float = 1.0
    known: bool = True


NONE = Fault(engine="")


class _Simulation:
    """A simulation whose states are tampered with."""

    def __init__(self, inner: Any, fault: Fault) -> None:
        self._inner, self._fault = inner, fault

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def state(self, out: Any) -> None:
        self._inner.state(out)
        self._fault.state(out)


class _Faulty:
    """An adapter with a fault."""

    def __init__(self, inner: Adapter, fault: Fault) -> None:
        self._inner, self._fault = inner, fault

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def build(self, scene: Scene, settings: Any) -> Any:
        return _Simulation(self._inner.build(self._fault.scene(scene), settings), self._fault)


def rougher(scene: Scene) -> Scene:
    """Three per cent more friction."""
    return replace(
        scene,
        surfaces=tuple(
            replace(surface, static_friction=1.03 * surface.static_friction, kinetic_friction=1.03 * surface.kinetic_friction)
            for surface in scene.surfaces
        ),
    )


def one_ulp_off(state: Any) -> None:
    """The last bit of one coordinate."""
    state.p_WB[0, 0] = np.nextafter(state.p_WB[0, 0], math.inf)


_KNOWN: dict[str, RunAnswer] = {}
"""What engines made of scenes, by all that decides it; arrays can't be written to."""


def _remembered(fault: Fault) -> Callable[[Trial, Problem, Any], RunAnswer]:
    """As `answer_of`, which is asked once in a process for the same: nights step the same scenes again and again."""
    plain = answer.answer_of

    def answer_of(trial: Trial, problem: Problem, adapter: Any) -> RunAnswer:
        own = (fault.scene, fault.state) if trial.engine == fault.engine else ()
        key = repr((trial.case, trial.parameters, trial.engine, trial.settings, trial.alteration, own, problem.scene))
        if key not in _KNOWN:
            _KNOWN[key] = answer = plain(trial, problem, adapter)
            for array in (getattr(answer.actual, name) for name in ("time", "p_WB", "q_WB", "v_WB", "w_WB")):
                array.setflags(write=False)
        return _KNOWN[key]

    return answer_of


_TRUE: dict[str, Converged | None] = {}
"""What answers were measured by, likewise."""


def _truth_of(case: Case, scene: Scene, time: Floats, parameters: Mapping[str, Any], *others: Any) -> Converged | None:
    """As the one that it stands for, which is asked once in a process for the same."""
    key = repr((case.name, dict(parameters), time.tolist(), scene))
    if key not in _TRUE:
        _TRUE[key] = truth_of(case, scene, time, parameters, *others)
    return _TRUE[key]


def _unedited(case: Case) -> Case:
    return case


@contextmanager
def planted(fault: Fault = NONE, judges: Callable[[Case], Case] = _unedited) -> Iterator[list[str]]:
    """Run nights in this process with a fault in one engine; steps cost the same under all settings. Gives: the names of the
    trials that are computed. Args: judges: how what judges answers was edited."""
    computed: list[str] = []

    def answers(
        trials: Sequence[Trial], folder: Path, _workers: int, earlier: Mapping[str, Record] = MappingProxyType({})
    ) -> Iterator[Record]:
        for trial in trials:
            case, known = judges(plugins.case(trial.case)), earlier.get(trial.trial)
            if known is not None and (anew := judged_anew(trial, case, known, folder)) is not None:
                yield replace(anew, simulated_as=known.simulated_as or known.trial)
                continue
            adapter = plugins.adapter(trial.engine)
            faulty: Any = _Faulty(adapter, fault) if trial.engine == fault.engine else adapter
            computed.append(trial.trial)
            answer = endure if trial.members > 1 else run_trial
            record = answer(trial, case, faulty, folder)
            yield replace(record, rough_cost=1e-5 / trial.settings.dt) if trial.experiment.sweep else record

    def blocks(trial: Trial) -> list[float]:
        price = (fault.price if trial.engine == fault.engine else 1.0) * 1e-5 * SLOW
        return [price * each for each in np.exp(np.random.default_rng(len(computed)).normal(0, NOISE, 5))]

    plain = campaign.sources_of

    def sources(case: str, engine: str) -> dict[str, str]:
        said = dict(plain(case, engine))
        text = f"{said['adapter']} {fault.scene.__name__} {fault.state.__name__} {fault.price}"
        said["harness"] += "" if judges is _unedited else judges.__name__
        return said | ({"adapter": text} if fault.known and engine == fault.engine else {})

    with pytest.MonkeyPatch.context() as patch:
        for module in (accuracy, ensemble):
            patch.setattr(module, "answer_of", _remembered(fault))
            patch.setattr(module, "truth_of", _truth_of)
        patch.setattr(campaign, "run_isolated", answers)
        clocked_by(patch, blocks)
        patch.setattr(campaign, "sources_of", sources)
        yield computed


def drawn(monkeypatch: pytest.MonkeyPatch, share: float) -> None:
    """Let another share of the known answers be computed again."""
    monkeypatch.setattr(night_policy, "AGAIN", share)


def asked(study: Study = STUDY, engines: Sequence[str] = ENGINES, **others: Any) -> NightWish:
    """What a night of few cells is asked for; our engine is gated."""
    cases = plugins.cases(lambda name: any(experiment.asks(name) for experiment in study.experiments))
    return NightWish(
        study=study, cases=cases, adapters={name: plugins.adapter(name) for name in engines}, gated=("reference",), **others
    )


def night(root: Path, what: NightWish | None = None) -> tuple[Night, News | None, dict[str, Any]]:
    """One night from its beginning to its end; with what changed, and its account."""
    history: History = created(root)
    what = what or asked()
    done = carry_out_night(history, what, night_to_do(history, what))
    write_summary(done.store)
    news = compared(done)
    account = accounted(done, news, 0.0)
    close(done.night, account)
    return done.night, news, account
