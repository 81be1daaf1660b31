"""The study of dominance on engines whose tuned track is beaten by planted knobs, carried out for real: all are found."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from plumbline.harness.cli.run_study import failures
from plumbline.harness.findings.tables import dominance as table
from plumbline.harness.findings.tables.dominance import TriedChange, changes, unexcused
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.search import dominance
from plumbline.harness.search.dominance import FACTORS, drawn_parameters
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.reports.pages.dominance import PAGE
from tests.known_prices import PLUGINS

CASE = "flight_projectile"
EXPERIMENT = Experiment(name="cases", cases=(CASE,), tracks=("tuned",), dominance=True, samples=5, sample_seconds=0.01)
STUDY = Study(name="dominance", recordings=False, experiments=(EXPERIMENT,))


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    """Both engines, in processes of their own; what is dearer is broken off early."""
    folder = tmp_path_factory.mktemp("dominance") / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(PLUGINS)
        patch.setattr(dominance, "LEAST", 0.5)
        engines = {name: plugins.adapter(name) for name in ("beaten", "failing")}
        yield carry_out(STUDY, folder, {CASE: plugins.case(CASE)}, engines, workers=2, resume=False)


@pytest.fixture(scope="module")
def found(store: Store) -> Mapping[tuple[str, str], TriedChange]:
    """By engine and change, each change on a row of its own."""
    return {(row.engine, change): row for row in changes(store) for change in row.change.split("; ")}


def test_a_cheaper_change_at_the_same_error_is_found_with_its_price(found: Mapping[tuple[str, str], TriedChange]) -> None:
    """20 us a step in the place of 50."""
    row = found["beaten", "spin 20.0"]
    assert (row.verdict, row.by, row.reason) == ("dominated", "price", "")
    assert row.cost is not None
    assert row.cost.ends[0] <= 0.4 * 1.03
    assert row.cost.ends[1] >= 0.4 * 0.97


def test_it_is_tried_at_drawn_parameters(found: Mapping[tuple[str, str], TriedChange]) -> None:
    row = found["beaten", "spin 20.0"]
    assert (row.won, row.drawn) == (len(FACTORS), len(FACTORS))
    assert row.draws.count("wins by price") == len(FACTORS)
    # Of one knob, the value that costs least stands for all.
    assert found["beaten", "spin 30.0"].drawn == 0


def test_a_change_that_the_adapter_names_is_excused_with_its_reason(
    store: Store, found: Mapping[tuple[str, str], TriedChange]
) -> None:
    row = found["beaten", "spin 30.0"]
    assert (row.verdict, row.by, row.reason) == ("excused", "price", "planted")
    sentences = unexcused(store)
    assert any("beaten/tuned with spin 20.0 costs" in sentence for sentence in sentences)
    assert f"dominance: {sentences[0]}" in failures(store)
    assert not any("beaten/tuned with spin 30.0" in sentence for sentence in sentences)


def test_a_reason_that_nothing_calls_for_is_told(store: Store) -> None:
    stale = [row for row in changes(store) if row.verdict == "reason not needed"]
    assert {(row.change, row.reason) for row in stale if row.engine == "beaten"} == {("shade", "never needed")}
    assert any("beaten gives a reason for shade" in sentence for sentence in table.TABLE.said(store))


def test_a_change_that_is_not_cheap_enough_is_no_better(found: Mapping[tuple[str, str], TriedChange]) -> None:
    """45 us a step in the place of 50, with the same bits; and an error that breaks a check."""
    assert found["beaten", "spin 45.0"].verdict == "same answer"
    assert found["beaten", "offset 100.0"].verdict == "no better"


def test_a_change_that_passes_more_checks_is_found_whatever_it_costs(found: Mapping[tuple[str, str], TriedChange]) -> None:
    row = found["failing", "offset 0.0"]
    assert (row.verdict, row.by) == ("dominated", "checks")
    assert row.held_change is not None
    assert row.held_tuned is not None
    assert row.held_change > row.held_tuned


def test_an_idle_knob_is_not_searched_and_told(store: Store, found: Mapping[tuple[str, str], TriedChange]) -> None:
    """The engine resolves its settings as before, whatever the colour is."""
    tried = {name for text in store.trials["settings"] for name in json.loads(text)["options"]}
    assert "colour" not in tried
    assert {found["beaten", f"colour {colour}"].verdict for colour in ("red", "blue")} == {"changes nothing"}


def test_what_an_engine_refuses_and_what_is_broken_off_are_outcomes(found: Mapping[tuple[str, str], TriedChange]) -> None:
    """5 ms a step in the place of 50 us can win by nothing: the track keeps all its checks."""
    assert found["beaten", "shade dark"].verdict == "refused"
    assert "option shade" in found["beaten", "shade dark"].reason
    assert found["beaten", "spin 5000.0"].verdict == "dearer"


def test_only_what_may_win_is_clocked(store: Store) -> None:
    clocked = store.trials[store.trials["cpu_per_unit"].notna()]
    assert set(clocked[clocked["engine"] == "beaten"]["track"]) == {"tuned", "tuned, spin 20.0", "tuned, spin 30.0"}


def test_table_and_page_tell_all_of_it(store: Store) -> None:
    flat = table.TABLE.rows(store)
    assert {row["verdict"] for row in flat} >= {"dominated", "excused", "no better", "refused", "changes nothing"}
    assert all(len(table.TABLE.brief(each)) == len(table.TABLE.shown) for each in table.TABLE.objects(store))
    sentences = table.TABLE.said(store)
    assert sentences[0].startswith("beaten: ")
    assert any("failing/tuned with offset 0.0 keeps" in sentence for sentence in sentences)
    page = dict(PAGE.render(store))["dominance.html"]
    assert isinstance(page, str)
    assert "planted" in page
    assert "spin 20.0" in page
    assert PAGE.concerns(store)


def test_drawn_parameters_are_the_same_for_all_and_leave_alone_what_is_swept() -> None:
    case = plugins.case("stack_pile")
    experiment = Experiment(name="e", tracks=("tuned",), parameters={"n": (10,)}, dominance=True)
    given = dict(case.parameters) | {"n": 10}
    drawn = list(drawn_parameters(experiment, case, given, case.dt))
    assert drawn == list(drawn_parameters(experiment, case, given, case.dt))
    assert [one["friction"] for one in drawn] == [0.5 * factor for factor in FACTORS]
    assert all(one["n"] == 10 and one["worlds"] == 1 for one in drawn)


def test_a_study_of_dominance_holds_changes_against_tuned_alone() -> None:
    with pytest.raises(ValueError, match="expected tuned alone"):
        Experiment(name="e", dominance=True)


def test_the_built_in_study_has_every_case_but_one(tmp_path: Path) -> None:
    from plumbline.harness.study.study import load_study

    study = load_study("dominance")
    names = plugins.names("cases")
    assert {name for name in names if not any(one.asks(name) for one in study.experiments)} == {"stack_ten_minutes"}
    assert all(one.dominance for one in study.experiments)
