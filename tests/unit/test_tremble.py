"""Why a machine trembles: the rule on made-up runs, and engines that tremble for a planted reason, through study and store."""

import math
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from pydantic import TypeAdapter

from plumbline.cases import stand_humanoid
from plumbline.harness.adapter import Adapter, Diverged, Feature, Settings
from plumbline.harness.findings.tables.tremble import CAUSES, TABLE, TrembleRun, attribute, findings
from plumbline.harness.scene import Revolute, Scene
from plumbline.harness.store.disk import write_atomically
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.seal import sealed_json, sealed_toml
from plumbline.harness.store.store import Store
from plumbline.harness.study.catalogue import describe_case
from plumbline.harness.study.experiment import Departure, departures_of
from plumbline.harness.study.study import Study, load_study
from plumbline.harness.trajectory import Contacts, State, Trajectory
from plumbline.harness.trial.accuracy import run_trial
from plumbline.reports.pages.tremble import PAGE
from tests.run_folder import write_run_folder

BOUND = 1e-3


def run(vibration: float) -> TrembleRun:
    return TrembleRun(vibration=vibration, frequency=30.0, bound=BOUND)


BASE = 0.1
SAME, HEALED, HALF = 0.08, 1e-5, 0.02
"""Vibrations beside a base of 0.1: as before, gone, and a fifth of it, which is neither."""


@pytest.mark.parametrize(
    ("changed", "cause", "words"),
    [
        ({"iterations": HEALED, "softer": SAME, "step": SAME, "product": SAME}, "iterations", "more iterations"),
        ({"iterations": SAME, "softer": HEALED, "step": SAME, "product": SAME}, "drives", "fight the contacts"),
        ({"iterations": SAME, "softer": HEALED, "step": HEALED, "product": SAME}, "drives", "too stiff for the step"),
        ({"softer": HEALED, "step": HEALED, "product": math.inf}, "drives", "too stiff for the step"),
        ({"iterations": SAME, "softer": SAME, "step": HEALED, "product": HEALED}, "time step", "shorter step alone"),
        ({"law": HEALED, "softer": HEALED, "step": SAME}, "drives", "another law"),
        # What the rule must not claim:
        ({"iterations": HEALED, "softer": HEALED, "step": SAME}, "not separated", "healed by iterations, softer"),
        ({"iterations": SAME, "softer": HEALED, "step": HEALED, "product": HEALED}, "not separated", "softer, step, product"),
        ({"iterations": SAME, "softer": HALF, "step": SAME, "product": SAME}, "not separated", "none of the changes"),
        ({"iterations": HEALED, "softer": HALF, "step": SAME}, "not separated", "healed by iterations"),
        ({"iterations": SAME, "softer": SAME, "step": SAME, "product": SAME}, "not separated", "none of the changes"),
        ({"iterations": HEALED}, "not separated", "healed by iterations"),
        ({"softer": HEALED}, "not separated", "healed by softer"),
        ({"step": HEALED}, "not separated", "healed by step"),
        ({"law": HEALED, "iterations": HEALED, "softer": SAME, "step": SAME}, "not separated", "iterations, law"),
        ({}, "not separated", "none of the changes"),
    ],
)
def test_the_rule(changed: Mapping[str, float], cause: str, words: str) -> None:
    _shares, found, why = attribute(run(BASE), {name: run(size) for name, size in changed.items()})
    assert (found, words in why) == (cause, True), why
    assert found in CAUSES


def test_a_still_machine_has_no_cause_whatever_the_changes_do() -> None:
    shares, cause, _ = attribute(run(0.9 * BOUND), {"softer": run(1e-9), "step": run(math.inf)})
    assert cause == "none (still)"
    assert shares["step"] == 0.0


def test_what_falls_before_and_after_is_not_healed_and_what_stands_up_is() -> None:
    shares, cause, _ = attribute(run(math.inf), {"softer": run(1e-5), "step": run(math.inf), "iterations": run(math.inf)})
    assert shares == {"iterations": 1.0, "softer": math.inf, "step": 1.0}
    assert cause == "drives"


def test_a_third_counts_only_with_the_bound() -> None:
    """From just above the bound to a quarter of it is healed; the same share far above the bound is not."""
    near = {"iterations": run(0.5 * BOUND), "softer": run(2 * BOUND), "step": run(2 * BOUND)}
    assert attribute(run(2 * BOUND), near)[1] == "iterations"
    far = {"iterations": run(25 * BOUND), "softer": run(100 * BOUND), "step": run(100 * BOUND)}
    assert attribute(run(100 * BOUND), far)[1] == "not separated"


class _Trembler:
    """Rest, but for hinges whose rates tremble at 40 Hz as strongly as `amplitude` of settings and stiffness says."""

    def __init__(self, scene: Scene, settings: Settings, amplitude: float) -> None:
        self._settings, self._time, self._amplitude = settings, 0.0, amplitude
        self._start = State.initial(scene)
        movable = [k for k, body in enumerate(scene.bodies) if body.movable]
        weight = sum(scene.bodies[k].mass for k in movable) * 9.81
        feet = [k for k in movable if scene.bodies[k].name.endswith("foot")]
        self._contacts = Contacts.of(
            [0, 0],
            feet,
            [[*scene.bodies[k].p_WB[:2], 0.0] for k in feet],
            [[0.0, 0.0, 1.0]] * 2,
            [0.0, 0.0],
            [[0.0, 0.0, weight / 2]] * 2,
        )
        self._head = scene.index("head")

    @property
    def resolved(self) -> Settings:
        return self._settings

    def step(self, count: int = 1) -> None:
        self._time += count * self._settings.dt
        if not math.isfinite(self._amplitude):
            raise Diverged("planted")

    def state(self, out: State) -> None:
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = (
            self._start.p_WB, self._start.q_WB, self._start.v_WB, self._start.w_WB,
        )  # fmt: skip
        if math.isfinite(self._amplitude):
            out.w_WB[self._head, 0] = self._amplitude * np.sin(2 * np.pi * 40 * self._time)

    def contacts(self) -> Contacts:
        return self._contacts

    def warnings(self) -> tuple[str, ...]:
        return ()

    def close(self) -> None:
        """Nothing to free."""


@dataclass(frozen=True, kw_only=True)
class _Planted(Adapter):
    """An engine that trembles for one reason."""

    title: str = "Planted"
    distribution: str = "numpy"
    features: Feature = Feature.REVOLUTE
    tracks: Mapping[str, Settings] = field(default_factory=lambda: {"default": Settings(iterations=4), "tuned": Settings()})
    reason: str = ""

    def version(self) -> str:
        return "1"

    def build(self, scene: Scene, settings: Settings) -> Any:
        waist = next(joint for joint in scene.joints if isinstance(joint, Revolute) and joint.name == "waist")
        assert waist.drive is not None
        stiffness = waist.drive.stiffness / 600.0
        # Every size is that of a mechanism, and grows like it; each law knows only its own quantity.
        size = {
            "iterations": 0.5 * math.exp(-(settings.iterations or 64) / 8),
            "contacts": 0.05 if stiffness > 0.75 else 1e-6,
            "explicit": math.inf if stiffness * settings.dt**2 > 0.75 / 240**2 else 1e-7,
            "step": 0.05 if settings.dt > 0.0035 else 1e-6,
            "law": 1e-7 if settings.integrator == "other" else 0.05,
            "nothing": 1e-7,
            "chaos": 0.05,
        }[self.reason]
        return _Trembler(scene, settings, size)


READ = ("pose_error_max", "vibration_rms", "vibration_frequency")
STANDING = cache(stand_humanoid.scene)
CASE = replace(
    stand_humanoid.CASE,
    scene=STANDING,
    expected=lambda time, p: Trajectory.at_rest(STANDING(p), time),
    duration=1.5,
    checks=tuple(check for check in stand_humanoid.CASE.checks if check.metric.name in READ),
    observe=tuple(metric for metric in stand_humanoid.CASE.observe if metric.name in READ),
)
"""The humanoid for half as long, with the metrics that the table reads; what else is measured of it has tests of its own."""
STUDY = {
    "name": "planted",
    "variants": {
        reason: {
            "many sweeps": {"on": "default", "beside": "default", "changes": "iterations", "iterations": 64},
            "the other way": {"on": "default", "beside": "default", "changes": "law", "integrator": "other"},
        }
        for reason in ("iterations", "contacts", "explicit", "step", "law", "nothing", "chaos")
    },
}
EXPECTED = {
    "iterations": ("iterations", "more iterations alone"),
    "contacts": ("drives", "fight the contacts"),
    "explicit": ("drives", "too stiff for the step"),
    "step": ("time step", "shorter step alone"),
    "law": ("drives", "another law"),
    "nothing": ("none (still)", "under the bound"),
    "chaos": ("not separated", "none of the changes"),
}


ASKED = {("coarse", True, 0.5), ("coarse", True, 1.0), ("coarse", False, 1.0), ("fine", True, 1.0), ("fine", True, 2.0)}
"""Experiment, whether on the track itself, stiffness: all that is said of the machine as it is described rests on these."""


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """The built-in study's own experiments, put to the planted engines."""
    folder = tmp_path_factory.mktemp("planted")
    given = load_study("tremble")
    study = Study(**(STUDY | {"experiments": given.experiments}))  # type: ignore[arg-type]
    engines = {reason: _Planted(name=reason, reason=reason) for reason in EXPECTED}
    catalogue = {"cases": {CASE.name: describe_case(CASE)}, "engines": {}}
    write_atomically(folder / "catalogue.json", sealed_json("catalogue.json", catalogue))
    write_atomically(folder / "study.toml", sealed_toml("study.toml", tomli_w.dumps({"variants": STUDY["variants"]})))
    with closing(Journal(folder)) as journal:
        for trial in study.trials({CASE.name: CASE}, engines, dict.fromkeys(engines, "1")):
            if (
                trial.experiment.name,
                trial.track == "default",
                trial.parameters["stiffness"],
            ) in ASKED and trial.track != "tuned":
                journal.append(run_trial(trial, CASE, engines[trial.engine], None))
    return Store(folder)


def test_a_study_says_what_its_variants_change(store: Store) -> None:
    assert departures_of(store)["law", "the other way"] == Departure("default", "law")


@pytest.mark.parametrize(
    ("variant", "said"),
    [
        ({"beside": "default"}, "beside is 'default', changes is None, expected both or none"),
        ({"beside": "lazy", "changes": "law"}, "variant 'dart/made': beside is 'lazy', expected one of default, tuned"),
        ({"beside": "made", "changes": "law"}, "beside is 'made', expected one of default, tuned"),
    ],
)
def test_a_variant_that_changes_another_names_one_that_is_there(variant: Mapping[str, str], said: str) -> None:
    experiment = {"name": "e", "cases": ["flight_box"]}
    with pytest.raises(ValueError, match=said):
        TypeAdapter(Study).validate_python({"name": "s", "variants": {"dart": {"made": variant}}, "experiments": [experiment]})


def test_the_study_itself_names_each_change_of_its_variants() -> None:
    variants = {(engine, name): one for engine, named in load_study("tremble").variants.items() for name, one in named.items()}
    assert {name for (_, name), one in variants.items() if one.changes is None} == {"hasty"}


@pytest.mark.parametrize("reason", EXPECTED)
def test_a_planted_reason_is_named(store: Store, reason: str) -> None:
    found = [one for one in findings(store) if one.engine == reason and one.stiffness == 1.0]
    cause, words = EXPECTED[reason]
    assert [one.cause for one in found] == [cause]
    assert words in found[0].why
    if cause not in ("none (still)",) and reason != "explicit":
        assert found[0].base.frequency == pytest.approx(40.0, abs=1.5)


def test_rows_say_all_in_numbers_and_in_short(store: Store) -> None:
    flat = TABLE.rows(store)
    assert all(tuple(row) == TABLE.columns for row in flat)
    assert {row["engine"] for row in flat} == set(EXPECTED)
    explicit = next(row for row in flat if row["engine"] == "explicit" and row["stiffness"] == 1.0)
    assert explicit["vibration_rad_s"] is None
    assert explicit["product"] == 1.0
    brief = [TABLE.brief(found) for found in TABLE.objects(store)]
    assert any("falls" in row for row in brief)
    assert all(len(row) == len(TABLE.shown) for row in brief)


def test_the_page_shows_each_engine_with_its_cause_and_stays_away_where_nothing_was_compared(
    store: Store, tmp_path: Path
) -> None:
    (page,) = PAGE.render(store).values()
    assert PAGE.concerns is not None
    assert PAGE.concerns(store)
    for cause, words in EXPECTED.values():
        assert f"<b>{cause}</b>" in page
        assert words in page
    write_run_folder(tmp_path)
    assert not PAGE.concerns(Store(tmp_path))
