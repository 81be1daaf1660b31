"""The page on price: there where steps were clocked, absent elsewhere; nothing that was run is lost from its charts."""

import csv
import io
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from markupsafe import escape

from plumbline.harness.findings.columns import at
from plumbline.harness.findings.prices import Reached, Silent, priced
from plumbline.harness.findings.standing import pair_leads
from plumbline.harness.findings.tables import price as price_table
from plumbline.harness.findings.tables.profile import FACTOR, TIME, profile
from plumbline.harness.findings.tables.steps import StepRange
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.largest_steps import survival
from plumbline.reports.charts.performance_profile import profile_chart
from plumbline.reports.charts.work_precision import miniatures, work_precision
from plumbline.reports.pages import index
from plumbline.reports.pages.price import PAGE
from plumbline.reports.tables.price_list import PriceLine, heat, price_list, scenes, wins
from plumbline.reports.tables.verdicts import failing
from plumbline.reports.words.text import duration, power
from tests.links import texts_of
from tests.run_folder import BAD_CASE, HOSTILE, write_run_folder
from tests.unit.test_prices import Priced, Told, ladder


def layers(figure: Figure, mark: str) -> Iterator[dict[str, Any]]:
    return (one for one in figure.spec["layer"] if one["mark"]["type"] == mark)


def rows_of(figure: Figure, layer: dict[str, Any]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = figure.spec["datasets"][layer["data"]["name"]]
    return found


def told() -> list[Told]:
    """Ours is cheap and reaches 1e-6, DART costs three times as much and reaches 1e-4; one step of it was not clocked."""
    return [*ladder("a", "reference", 1e-3), *ladder("a", "dart", 3e-3, finest=1e-2), ("a", "dart", "default", 1e-2, 0.2, None)]


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    cases = ("flight_projectile", "friction_creep", "friction_stop", "joint_pendulum", "stack_tower", BAD_CASE)
    return Store(write_run_folder(tmp_path_factory.mktemp("price") / "run", hostile=True, only=cases))


def chart_of(store: Store, case: str) -> Figure:
    (scene,) = (scene for scene in scenes(store) if scene.case == case)
    return work_precision(store, scene)


def test_without_several_clocked_steps_there_is_no_such_page_and_no_link_to_it() -> None:
    single = Priced([one for one in told() if one[3] == 1e-2])
    texts = texts_of(single, "price", "index")
    assert "price.html" not in texts
    assert "price.html" not in texts["index.html"]


def test_settings_of_a_search_stand_on_the_case_page_and_not_as_tracks_of_the_overview() -> None:
    turned = "tuned, iterations 4"
    store = Priced([*told(), ("a", "reference", turned, 1e-3, 5e-4, None)])
    trials = store.trials
    trials.loc[trials["track"] == turned, "round"] = 2
    texts = texts_of(store, "index", "case")
    assert turned not in texts["index.html"]
    assert turned in next(text for name, text in texts.items() if name.startswith("case") and name.endswith("a.html"))


def test_settings_of_a_sweep_are_no_marks_of_the_overview() -> None:
    """Without telling them apart, each would be a mark of its own, filled as if it were tuned."""
    turned = ("tuned, iterations 4", "default, solver pgs")
    named = [*told(), ("a", "reference", "default", 1e-2, 3e-3, 0.1)]
    store = Priced([*named, *(("a", "reference", track, 1e-2, 1e-5, 1e-4) for track in turned)])
    store.trials.loc[store.trials["track"].isin(turned), "round"] = 1
    with_sweep, without = (index.PAGE.render(one) for one in (store, Priced(named)))
    for chart in ("overview-error", "overview-cost"):
        drawn, alone = with_sweep[f"charts/{chart}.svg"], without[f"charts/{chart}.svg"]
        assert isinstance(drawn, Figure)
        assert isinstance(alone, Figure)
        marks = [(row["engine"], row["track"]) for rows in drawn.spec["datasets"].values() for row in rows]
        assert ("reference (ours)", "default") in marks
        assert {track for _, track in marks} <= {"default", "tuned"}
        assert len(set(marks)) == len(marks)
        assert drawn.rows == alone.rows


def test_what_a_sweep_fails_is_no_failure_of_its_engine() -> None:
    turned = "tuned, iterations 4"
    store = Priced([*told(), ("a", "reference", turned, 1e-2, 2.0, 1e-4)])
    trials = store.trials
    trials.loc[trials["track"] == turned, "round"] = 1
    trials.loc[(trials["engine"] == "reference") & (trials["dt"] == 1e-2), "status"] = "failed"
    assert [(failure.cause.engine, failure.cause.track) for failure in failing(store)] == [("reference", "tuned")]


def test_with_them_there_is_the_page_its_tables_and_a_link() -> None:
    texts = texts_of(Priced(told()), "index", "price", "case")
    assert 'href="price.html"' in texts["index.html"]
    page = texts["price.html"]
    # Lines for errors of 1e-1 to 1e-7, the first that nobody reaches, and the steps of the one engine with four of them.
    assert page.count("<tr data-status=") == 7 + 1
    assert "not by dt 1/1000 s, best 5" in page
    prices = list(csv.DictReader(io.StringIO(texts["price.csv"])))
    assert len(prices) == 8 * 2
    assert {"profile.csv", "steps.csv", "charts/profile-factor.svg", "charts/largest-steps.svg"} <= texts.keys()
    assert 'id="prices"' in texts["case-a.html"]


def test_every_trial_of_a_case_is_on_its_chart_or_counted_above_it(store: Store) -> None:
    for case in ("stack_tower", "friction_stop", "flight_projectile"):
        (scene,) = (scene for scene in scenes(store) if scene.case == case)
        figure = work_precision(store, scene)
        trials = list(store.trials.loc[store.trials["case"] == case, "trial"])
        standing = [row[-1] for row in figure.rows]
        assert sorted([*standing, *scene.silent["trial"]]) == sorted(trials)
        drawn = {row["trial"] for one in layers(figure, "point") if "shape" in one["encoding"] for row in rows_of(figure, one)}
        assert drawn == set(standing)


def test_outcomes_without_a_place_are_counted_above_the_frame(store: Store) -> None:
    figure = chart_of(store, "friction_creep")
    counted = {row["engine"]: row["text"] for one in layers(figure, "text") for row in rows_of(figure, one)}
    assert counted == {"Bullet": "∅ 12", "Newton": "○ 12"}


def test_a_trial_that_was_not_clocked_is_small_faint_and_says_so() -> None:
    figure = chart_of(Priced(told()), "a")
    faint = [one for one in layers(figure, "point") if one["mark"]["size"] < 30]
    assert [(row["engine"], row["timing"]) for one in faint for row in rows_of(figure, one)] == [("dart", "rough, not clocked")]
    assert "not clocked" in figure.how


def test_the_front_of_each_engine_is_a_line_and_the_front_of_all_is_ringed() -> None:
    figure = chart_of(Priced(told()), "a")
    (line,) = layers(figure, "line")
    assert [row["engine"] for row in rows_of(figure, line)] == ["reference (ours)"] * 4 + ["dart"] * 3
    (rings,) = (one for one in layers(figure, "point") if one["mark"]["size"] > 200)
    assert [row["engine"] for row in rows_of(figure, rings)] == ["reference (ours)"] * 4


def test_a_list_ends_at_the_first_error_that_nobody_reaches_and_shades_by_the_ratio() -> None:
    lines = price_list(Priced(told()))
    assert [line.target for line in lines] == [power(-k) for k in range(1, 8)]
    assert [line.last for line in lines] == [False] * 6 + [True]
    first: PriceLine = lines[1]
    assert at(first.entries["reference"].price, "reached.cost.value") == pytest.approx(
        1e-3 / 0.1, rel=1e-9
    )  # 0.1 s errs 5e-3 already
    assert (first.entries["reference"].shade, first.entries["dart"].shade, first.entries["dart"].ratio) == ("x1", "x1", "")
    # The other's is a bound too: of two bounds there is no ratio.
    assert first.entries["reference"].text == "≥ 100\N{MULTIPLICATION SIGN}"
    assert lines[5].entries["dart"].text.startswith("not by dt 1/100 s, best 5")
    assert lines[5].entries["dart"].shade == heat(None) == "out"


def test_terminal_and_page_count_alike_who_is_cheapest_and_nobody_whose_order_is_not_known() -> None:
    """Bullet takes three times as long and errs as much. Where its coarsest step errs less than asked, larger ones, which were
    not tried, might be cheaper; ours would be cheapest of all and is not ranked."""
    store = Priced([*told(), *ladder("a", "bullet", 9e-3)])
    prices = priced(store).prices
    bounds = sum(price.verdict == "at most" for price in prices if price.engine == "bullet")
    alone = {name: sum(price.reached is not None for price in prices if price.engine == name) for name in ("dart", "bullet")}
    assert (bounds, alone) == (2, {"dart": 4, "bullet": 6})
    won = wins(prices)
    assert (won.counts, won.open) == ([("bullet", 2), ("dart", 2)], bounds)
    (sentence,) = price_table.TABLE.sentences(prices)
    assert sentence == (
        "Of 6 pairs of case and error that an engine to deploy reaches, cheapest: bullet 2, dart 2; in 2 intervals meet or "
        "larger steps were not tried, and nobody is counted."
    )
    at_time = [lead for lead in pair_leads(prices, priced(store).points) if (lead.at, lead.ours) == ("equal time", False)]
    assert [(lead.engine, lead.alone, lead.shared) for lead in at_time] == [("bullet", 2, 2), ("dart", 2, 2)]


def test_where_intervals_of_costs_meet_nobody_is_counted_as_cheapest() -> None:
    prices = priced(Priced([*ladder("a", "dart", 1.0), *ladder("a", "bullet", 1.1)])).prices

    def widened(met: Reached) -> Reached:
        return replace(met, cost=Interval(met.cost.value, 0.9 * met.cost.value, 1.2 * met.cost.value))

    wide = [price if price.reached is None else replace(price, outcome=widened(price.reached)) for price in prices]
    assert wins(prices).counts[0] == ("dart", 4)
    assert (wins(wide).known, wins(wide).open) == (0, 6)


def test_an_engine_without_any_answer_has_lost_to_nobody_and_one_left_alone_has_won_nothing() -> None:
    prices = priced(Priced([*told(), *ladder("a", "bullet", 9e-3)])).prices
    silent = [
        replace(price, outcome=Silent(verdict="no answer", reason="")) if price.engine == "dart" else price for price in prices
    ]
    assert (wins(prices).alone, wins(silent).alone) == ("", "bullet")
    assert [name for name, _ in wins(silent).counts] == ["bullet"]
    shares = [share for share in profile(priced(Priced(told())).prices) if share.engine == "reference"]
    assert profile_chart(Priced(told()), shares, FACTOR) is None


def test_every_scene_has_a_line_for_the_error_that_the_list_shows_at_first() -> None:
    told: list[Told] = [("a", "dart", "tuned", dt, 0.9, 1.0) for dt in (1e-2, 1e-3)]
    assert [(line.target, line.last) for line in price_list(Priced(told))] == [("10⁻¹", False), ("10⁻²", True)]


def test_profiles_have_a_line_and_a_band_for_each_engine() -> None:
    one = Priced(told())
    shares = profile(priced(one).prices)
    for limit in (FACTOR, TIME):
        figure = profile_chart(one, shares, limit)
        assert figure is not None
        assert {row["engine"] for mark in ("line", "area") for row in rows_of(figure, next(layers(figure, mark)))} == {
            "reference (ours)",
            "dart",
        }
    assert profile_chart(one, [], FACTOR) is None


def step(accurate: float | None, coarsest: float) -> StepRange:
    return StepRange(
        case="a", where="", engine="dart", track="tuned", stable=None, stable_substeps=None, accurate=accurate,
        accurate_substeps=None, coarsest=coarsest, finest=1e-3, finest_substeps=1, runs=4, error=None, realtime=None, trial="",
    )  # fmt: skip


def test_scenes_that_were_not_run_more_coarsely_count_up_to_where_they_were() -> None:
    """By hand: of five scenes one never is within; one ends after 2 ms, one is censored at 4 ms, one ends after 4 ms."""
    scenes = [step(None, 8e-3), step(2e-3, 8e-3), step(4e-3, 4e-3), step(4e-3, 8e-3), step(8e-3, 8e-3)]
    found = survival(scenes)
    assert [(dt, left) for dt, _, left in found] == [(2e-3, 4), (4e-3, 3), (8e-3, 1)]
    assert [share for _, share, _ in found] == pytest.approx([4 / 5, 4 / 5 * 3 / 4, 4 / 5 * 3 / 4 * 2 / 3])


def test_miniatures_share_their_axes_and_lead_to_the_chart_of_their_case(store: Store) -> None:
    small = miniatures(store)
    assert len({(tuple(one.across), tuple(one.up)) for one in small}) == 1
    for one in small:
        assert all(0 <= x <= 200 and 0 <= y <= 132 for _, _, places in one.lines for x, y in places)
    addresses = [one.address for one in small]
    assert "case-joint_pendulum.html#case-joint_pendulum-price" in addresses


def test_a_hostile_name_stays_text(store: Store) -> None:
    page = PAGE.render(store)["price.html"]
    assert escape(HOSTILE[0]) in page
    assert HOSTILE[0] not in page
    assert HOSTILE[2] not in page


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (1.23e-5, "12.3 µs"),
        (9.999e-4, "1 ms"),
        (2.5, "2.5 s"),
        (3.82e-8, "38.2 ns"),
        (1e-12, "0.001 ns"),
        (None, "\N{EN DASH}"),
        (0.0, "\N{EN DASH}"),
    ],
)
def test_a_time_is_told_in_its_unit(seconds: float | None, words: str) -> None:
    assert duration(seconds) == words


def test_a_power_of_ten_is_told_as_one() -> None:
    assert [power(k) for k in (-3, 0, 1, 2)] == ["10⁻³", "1", "10", "10²"]


def test_a_price_says_what_of_its_laws_the_adapter_makes() -> None:
    """Of what the case uses, and on the track whose settings it has: 'default, iterations 4' is built on default."""
    store = Priced([*ladder("a", "reference", 1e-3), *ladder("a", "dart", 3e-3, track="default, iterations 4")])
    made = {"how": "a torque", "where": "", "tracks": ["default"]}
    store.catalogue["engines"]["dart"] |= {
        "tracks": {"default": {}, "tuned": {}},
        "emulated": [made | {"feature": "springs"}, made | {"feature": "drives"}],
    }
    store.catalogue["cases"]["a"]["features"] = ["springs"]
    entries = {name: one for line in price_list(store) for name, one in line.entries.items()}
    assert {name: one.law for name, one in entries.items()} == {"reference": "", "dart": "springs emulated"}
    assert "springs emulated by the adapter" in entries["dart"].hint
    pages = texts_of(store, "price", "case")
    assert "<small>springs emulated</small>" in pages["price.html"]
    assert "<small>springs emulated</small>" in pages["case-a.html"]
