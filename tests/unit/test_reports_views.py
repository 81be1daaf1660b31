"""What the report reads off a store: outcomes, ratios and sentences, against counts done by hand."""

import math
from collections import Counter
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from plumbline.harness.store.record import Status
from plumbline.harness.store.store import Store
from plumbline.reports.tables.engine_summary import glances
from plumbline.reports.tables.summary import sentences
from plumbline.reports.tables.trial_results import answers, at_own_step
from plumbline.reports.tables.verdicts import totals, verdicts
from plumbline.reports.words.catalogue import cases, engines, families, tracks
from plumbline.reports.words.status import STATUSES, outcome, worst
from tests.run_folder import BAD_CASE, HOSTILE, row, write_run_folder


class Rows(Store):
    """A store whose tables are given."""

    def __init__(self, trials: list[dict[str, Any]], errors: dict[str, float], cases: dict[str, Any]) -> None:
        self.folder = Path("run")
        self.__dict__["_read"] = {
            "trials": pd.DataFrame(trials).astype({"unstable_timing": "boolean"}),
            "measurements": pd.DataFrame(
                [{"trial": t, "metric": "e", "value": v, "unit": "m", "at_most": 1.0, "passed": True, "because": ""}
                 for t, v in errors.items()],
                columns=["trial", "metric", "value", "unit", "at_most", "passed", "because"],
            ),
            "samples": pd.DataFrame({"trial": []}),
        }  # fmt: skip
        titles = {"reference": {"title": "Ref", "ours": True}, "mujoco": {"title": "Mu"}, "dart": {"title": "Da"}}
        self.__dict__["catalogue"] = {"cases": cases, "engines": titles}
        self.__dict__["machine"] = self.__dict__["study"] = {}


CASE = {"headline": "e", "dt": 0.01, "scale": 1.0}


def small() -> Rows:
    """Two cases, three engines, tuned: costs 1, 2 and 4, errors 4, 2 and 1; one engine diverges in the second case."""
    trials, errors = [], {}
    for case in ("flight_a", "rest_b"):
        for engine, cost in (("reference", 4.0), ("mujoco", 1.0), ("dart", 2.0)):
            name = f"{case}-{engine}"
            trial = row(case, engine, "tuned", 0.01, trial=name, cpu_per_sim_s=cost)
            if name == "rest_b-dart":
                trial |= {"status": "diverged", "reason": "not finite", "cpu_per_sim_s": math.nan}
            else:
                errors[name] = 4.0 / cost
            trials.append(trial)
    return Rows(trials, errors, {"flight_a": CASE | {"title": "A"}, "rest_b": CASE | {"title": "B"}})


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(write_run_folder(tmp_path_factory.mktemp("views") / "run", hostile=True))


def test_every_status_of_a_record_has_an_outcome_with_a_symbol_of_its_own() -> None:
    assert tuple(STATUSES) == Status.__args__  # type: ignore[attr-defined]
    assert len({one.symbol for one in STATUSES.values()}) == len(STATUSES)
    assert len({one.rank for one in STATUSES.values()}) == len(STATUSES)


def test_a_status_from_the_future_is_shown_as_unknown_and_as_the_worst() -> None:
    assert outcome("melted").name == "unknown"
    assert worst(["passed", "melted", "crashed"]).name == "unknown"


def test_no_trial_is_lost_between_the_store_and_the_rows(store: Store) -> None:
    assert list(answers(store)["trial"]) == list(store.trials["trial"])
    assert sum(cell.trials for cell in verdicts(store).values()) == len(store.trials)
    cells = store.trials.groupby(["case", "engine", "track"]).ngroups
    assert sum(sum(counts.values()) for counts in totals(store).values()) == cells


def test_a_trial_without_an_answer_has_no_error_even_where_a_metric_was_left_behind(store: Store) -> None:
    rows = answers(store)
    bad = rows[rows["case"] == BAD_CASE]
    assert Counter(bad["status"]) == Counter([*STATUSES, "passed", "failed"])
    assert bad.loc[~bad["status"].isin(["passed", "failed"]), "error"].isna().all()
    assert (bad.loc[bad["status"].isin(["passed", "failed"]), "error"] == 0.5).all()


def test_a_series_holds_the_trials_that_differ_in_step_only(store: Store) -> None:
    rows = answers(store)
    sizes = rows[rows["case"] == "joint_pendulum"].groupby("series").size()
    assert set(sizes) == {6}
    assert len(sizes) == 10


def test_at_their_own_step_each_case_engine_and_track_has_one_trial(store: Store) -> None:
    own = at_own_step(store, answers(store))
    own = own[own["case"] != BAD_CASE]
    assert (own["dt"] == 1 / 240).all()
    assert not own.duplicated(["case", "engine", "track"]).any()


def test_a_case_that_never_ran_at_its_own_step_is_read_at_the_nearest() -> None:
    trials = [row("a", "dart", "tuned", dt) for dt in (0.1, 0.02, 0.001)]
    rows = Rows(trials, {}, {"a": CASE})
    assert list(at_own_step(rows, answers(rows))["dt"]) == [0.02]


def test_cases_and_engines_that_the_catalogue_lacks_are_still_listed() -> None:
    rows = Rows([row("odd_case", "odd", "tuned", 0.01)], {}, {})
    assert list(cases(rows)) == ["odd_case"]
    assert cases(rows)["odd_case"]["title"] == "odd_case"
    assert list(engines(rows)) == ["odd"]


def test_our_own_engine_comes_last_and_default_before_tuned(store: Store) -> None:
    assert list(engines(store))[-1] == "reference"
    assert tracks(store) == ["default", "tuned"]


def test_families_come_from_the_simple_to_the_composed(store: Store) -> None:
    titles = [title for title, _ in families(store)]
    assert titles[:4] == ["Free flight", "Free rotation", "Joints", "Impacts"]
    assert [case["name"] for _, listed in families(store) for case in listed if case["family"] == "joint"] == [
        "joint_pendulum",
        "joint_chain",
    ]


def test_ratios_are_geometric_means_over_the_cases_that_all_answered() -> None:
    seen = {one.engine: one for one in glances(small())}
    # Only flight_a has numbers of all three: costs 4, 1, 2 over the least, 1; errors 1, 4, 2 over the least that is not
    # ours, 2. The yardstick stands on that scale and wins nothing.
    assert {name: one.relative_cost for name, one in seen.items()} == pytest.approx({"reference": 4, "mujoco": 1, "dart": 2})
    assert {name: one.relative_error for name, one in seen.items()} == pytest.approx({"reference": 0.5, "mujoco": 2, "dart": 1})
    assert {one.shared for one in seen.values()} == {1}
    assert {name: one.best for name, one in seen.items()} == {"reference": None, "mujoco": 1, "dart": 1}


def test_an_engine_that_answers_little_or_nothing_does_not_empty_the_others(store: Store) -> None:
    seen = {(one.engine, one.track): one for one in glances(store)}
    assert seen["newton", "tuned"].relative_cost is None
    assert seen["mujoco", "tuned"].relative_cost == pytest.approx(1.0)


def test_an_error_of_exactly_zero_wins_its_case_and_breaks_no_mean() -> None:
    trials = [row("a", engine, "tuned", 0.01, trial=engine) for engine in ("dart", "mujoco")]
    seen = {one.engine: one for one in glances(Rows(trials, {"dart": 0.0, "mujoco": 1.0}, {"a": CASE}))}
    assert (seen["dart"].best, seen["mujoco"].best) == (1, 0)
    assert seen["mujoco"].relative_error == pytest.approx(1e6)  # 1 of the scale over a millionth


def test_errors_that_are_level_win_their_case_for_each() -> None:
    trials = [row("a", engine, "tuned", 0.01, trial=engine) for engine in ("dart", "mujoco", "bullet")]
    errors = {"dart": 0.5, "mujoco": 0.504, "bullet": 0.51}
    seen = {one.engine: one.best for one in glances(Rows(trials, errors, {"a": CASE}))}
    assert seen == {"dart": 1, "mujoco": 1, "bullet": 0}


def test_the_summary_says_what_the_tables_say() -> None:
    told = sentences(small())
    assert told[0] == "On the tuned track Mu passes most cases at their nominal time step: 2 of 2 (Da 1/2)."
    plain = told[1].replace("\N{MULTIPLICATION SIGN}", " times")
    assert plain.endswith("in CPU time Mu 1 times, Da 2 times; in error Da 1 times, Mu 2 times.")
    beside = [sentence.replace("\N{MULTIPLICATION SIGN}", " times") for sentence in told if sentence.startswith("Beside them")]
    assert beside == [
        "Beside them Ref, tuned, takes 4 times the CPU time of the cheapest of each case, at 0.5 times the smallest error."
    ]
    assert not any("Ref" in sentence for sentence in told[:2]), "the reference engine is in no headline"
    assert "Ref is ours; tuned, it passes every trial that was put to it." in told
    assert told[-1] == "6 trials of 2 cases on 3 engines: 5 passed and 1 diverged."


def test_the_summary_names_where_our_own_engine_falls_short() -> None:
    rows = small()
    trials = rows.trials
    trials.loc[trials["trial"] == "rest_b-reference", "status"] = "failed"
    assert "Ref is ours; tuned, it falls short in “B”." in sentences(rows)


def test_the_summary_of_an_attack_is_text_like_any_other(store: Store) -> None:
    assert any(HOSTILE[2] in sentence for sentence in sentences(store))


def test_an_empty_store_has_one_sentence() -> None:
    rows = small()
    rows.__dict__["_read"]["trials"] = rows.trials.iloc[:0]
    assert sentences(rows) == ["The store holds no trial."]
