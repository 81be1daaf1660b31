"""A scene of one's own, carried out: verdicts, errors beside costs, words at the end, and a page as good as the others."""

import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.case.own_titles import title_of
from plumbline.harness.case.scene_file import own_case
from plumbline.harness.cli.own_scene import closing_count, closing_words
from plumbline.harness.findings import tables
from plumbline.harness.findings.agreement import agreements, balances, errors_of, outlooks
from plumbline.harness.findings.prices import Prices
from plumbline.harness.findings.selection import Wish, choose
from plumbline.harness.findings.selection.evidence import DECADES_OF_SPEED
from plumbline.harness.findings.selection.words import headline
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.scene import Body, Scene, sphere_inertia
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.own_scene import study_of
from plumbline.harness.study.study import Study
from plumbline.reports import build, write_recordings
from plumbline.reports.html import report as html
from plumbline.reports.page import pages
from plumbline.reports.pages.scene import PAGE
from tests.in_process import clocked_by, in_this_process
from tests.known_prices import LAWS, PLUGINS
from tests.links import dangling
from tests.own_limits import pile

ENGINES = ("spinner", "laggard")
"""A third party's, which err by a law that is known: `tests.known_prices`."""
DURATION = 1.0
"""s: what is thrown comes down within that, and a box that falls for a fifth of it lies still at its end."""


@dataclass(frozen=True)
class Done:
    store: Store
    case: str


def carried_out(folder: Path, scene: Scene, engines: tuple[str, ...], name: str, **changes: object) -> Done:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(dump_toml(scene))
    path.with_suffix(".plumb.toml").write_text(f"duration = {DURATION}\n")
    case = plugins.case(f"{plugins.SCENE_PREFIX}{path}")
    study = study_of(case)
    ladder = replace(study.experiments[0], **{"samples": 3, "sample_seconds": 0.001} | changes)
    chosen = Study(name=study.name, title=study.title, purpose=study.purpose, experiments=(ladder,))
    adapters = {engine: plugins.adapter(engine) for engine in engines}
    store = carry_out(chosen, folder / "run", {case.name: case}, adapters, workers=2, resume=False)
    return Done(store, case.name)


def counted(simulation: Any, count: int = 1) -> None:
    """Steps whose price is not burnt, since a formula says it."""
    simulation._steps += count


@pytest.fixture(scope="module")
def thrown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Done]:
    ball = Body(name="ball", inertia=sphere_inertia(1.0, 0.1), p_WB=(0, 0, 1), v_WB=(3, 0, 4))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(PLUGINS)
        in_this_process(patch)
        clocked_by(patch, lambda trial: [LAWS[trial.engine, trial.track].spin] * 3)
        patch.setattr("spinner.Spinning.step", counted)
        scene, folder = Scene(bodies=(ball,)), tmp_path_factory.mktemp("own")
        yield carried_out(folder, scene, ENGINES, "my_thrown-ball.toml", refine=Refinement(finest=1 / 1920))


def test_the_study_of_a_scene_halves_the_step_on_both_tracks_of_every_engine(thrown: Done) -> None:
    trials = thrown.store.asked
    for engine in ENGINES:
        for track in ("default", "tuned"):
            part = trials[(trials["engine"] == engine) & (trials["track"] == track)]
            assert sorted(round(1 / dt) for dt in part["dt"]) == [240, 480, 960, 1920]


def test_two_engines_agree_and_every_error_is_its_law(thrown: Done) -> None:
    """The limit of both is the parabola; an engine of order p errs by 0.02 m (60 dt)^p from it, a share of the ball's size."""
    (found,) = agreements(thrown.store)
    assert found.agreed == "A"
    assert {side.word for side in found.sides} == {"agrees"}
    errors = errors_of(thrown.store)
    for row in thrown.store.asked.itertuples():
        law = LAWS[row.engine, row.track]
        share = law.error(row.dt) / found.scale.largest
        assert errors[row.trial].error == pytest.approx(share, abs=found.bar + 1e-12)
        assert errors[row.trial].off == found.bar
    orders = {(side.engine, side.track): side.limit.said.order for side in found.sides}
    assert orders == {key: pytest.approx(LAWS[key].order, abs=0.02) for key in orders}


def test_the_table_has_a_row_for_each_engine_and_track_with_what_a_step_costs(thrown: Done) -> None:
    table = tables.table("agreement")
    rows = table.rows(thrown.store)
    assert len(rows) == 4
    assert all(tuple(row) == tuple(table.columns) for row in rows)
    for row in rows:
        assert row["verdict"] == "agrees"
        steps, errors, costs, trials = (json.loads(row[name]) for name in ("steps", "errors", "costs", "trials"))
        assert steps == sorted(steps, reverse=True)
        assert len(steps) == len(errors) == len(costs) == len(trials) == 4
        assert all(cost is not None and cost > 0 for cost in costs)
        assert len(table.brief(row)) == len(table.shown)
        assert not any(isinstance(value, list | dict) for value in row.values())


def test_errors_from_the_agreed_limit_have_prices(thrown: Done) -> None:
    prices = [price for price in Prices(thrown.store).prices if price.target == 1e-2]
    assert {price.engine for price in prices} == set(ENGINES)
    assert all(price.cost is not None for price in prices)
    assert len([price for price in prices if price.cheapest]) == 1


def test_what_is_bounded_at_the_coarsest_step_asked_for_is_a_price(thrown: Done) -> None:
    """An error that the coarsest step of both does not reach: nobody asked for a coarser one, so what that costs decides."""
    listed = {price.engine: price for price in Prices(thrown.store).prices if price.target == 1e-1}
    assert {price.verdict for price in listed.values()} == {"at most"}
    cheapest, dearest = sorted(listed, key=lambda name: listed[name].cost or 0.0)
    found = choose(thrown.store, Wish(max_error=1e-1, weights={"accuracy": 0.0}), draws=500)
    assert found.rank is not None
    assert [(place.engine, place.number) for place in found.rank.places] == [(cheapest, 1), (dearest, 2)]
    assert found.evidence.tracks == dict.fromkeys(listed, "tuned")  # both tracks cost the same, and the tuned one errs less
    ratio = (listed[dearest].cost or 0.0) / (listed[cheapest].cost or 1.0)
    for engine, score in ((cheapest, 1.0), (dearest, max(0.0, 1 - math.log10(ratio) / DECADES_OF_SPEED))):
        datum = found.evidence.table["speed", thrown.case, engine]
        assert datum.value == pytest.approx(score)
        assert "at most" not in datum.says
        assert datum.says.endswith(" times real time at its nominal step")
    assert "too few" not in headline(found, str)


def test_the_run_ends_with_verdicts_and_never_with_a_bare_passed(thrown: Done) -> None:
    said = closing_words(thrown.store)
    assert "agree on one limit to the end" in said[0]
    assert sum(": agrees (order " in sentence for sentence in said) == 4
    (costs,) = [sentence for sentence in said if "times real time" in sentence.lower()]
    listed = {price.engine: price for price in Prices(thrown.store).prices if price.target == 1e-2}
    paced = sorted(listed.values(), key=lambda price: price.cost or 0.0)
    told = re.findall(r"([\d.e+]+) \((\w+), dt 1/(\d+) s\)", costs)
    assert told == [(f"{1 / (price.cost or 1.0):.3g}", price.track, f"{1 / (price.dt or 1.0):.4g}") for price in paced]
    for sentence in (*said, closing_count(thrown.store)):
        assert "passed" not in sentence
    assert closing_count(thrown.store) == "16 trials: 16 finite"


def test_the_page_is_as_good_as_the_others(thrown: Done, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html, "pages", lambda: tuple(page for page in pages() if page.name in (PAGE.name, "case", "index")))
    write_recordings(thrown.store.folder)
    report = build(thrown.store.folder).index.parent
    (page,) = report.glob("case-*.html")
    text = page.read_text()
    assert "<h1>My thrown ball</h1>" in text
    assert "Your scenes" in text
    assert "[]" not in re.sub(r'<script type="application/json".*?</script>', "", text, flags=re.DOTALL)
    assert "none was kept" not in text
    (link,) = re.findall(r'href="(\.\./recordings/[^"]+)"', text)
    assert (report / link).is_file()
    for title in ("Error against time step", "Speed against error", "Horizon"):
        assert title in text
    assert "distance from the limit [of its size]" in text
    index = (report / "index.html").read_text()
    assert re.search(r'id="which".*<b>My thrown ball</b>.*is first in ', index, re.DOTALL)
    assert re.search(r'class="figures"><span>[\d.]+\N{MULTIPLICATION SIGN}</span> <span>[\d.]+ %</span>', index)
    assert "passed [cases]" not in index
    for told in (text, index):
        shown = re.sub(r"<script.*?</script>", "", told, flags=re.DOTALL)
        assert "agrees" in shown
        assert not re.search(r"[✓0-9] passed", shown)


def test_every_link_of_a_report_of_ones_own_scene_leads_somewhere(thrown: Done, fallen: Done) -> None:
    assert dangling(thrown.store.folder) == dangling(fallen.store.folder) == []


def test_a_title_is_made_of_the_files_name() -> None:
    assert title_of(Path("/a/my_robot-arm.v2.toml")) == "My robot arm.v2"


def test_the_family_of_a_scene_of_ones_own_is_not_its_path(tmp_path: Path) -> None:
    path = tmp_path / "with_blank_ball.toml"
    path.write_text(dump_toml(Scene(bodies=(Body(name="b"),))))
    assert own_case(path, plugins.SCENE_PREFIX).family == "scene"


@pytest.fixture(scope="module")
def fallen(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """A box that falls, on two engines, with a short ladder, and three perturbed starts where it is known for a moment only."""
    refine = Refinement(finest=1 / 960, further=0, members=3)
    asked = {"refine": refine, "timing": False, "tracks": ("tuned",)}
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        return carried_out(tmp_path_factory.mktemp("pile"), pile(1), ("mujoco", "dart"), "pile.toml", **asked)


def test_a_pile_is_judged_by_what_stays_defined(fallen: Done) -> None:
    (found,) = agreements(fallen.store)
    assert max(side.limit.until for side in found.sides) < 1.0
    laws = {(one.engine, one.law): one for one in balances(fallen.store, found)}
    for engine in ("mujoco", "dart"):
        for law in ("energy_gain_max", "penetration", "signorini_residual", "cone_residual"):
            assert (engine, law) in laws
        # What falls wins no energy, whoever makes it fall; what a blow does within a step is shown, and not judged.
        assert laws[engine, "energy_gain_max"].holds
        assert laws[engine, "cone_residual"].holds is None
    first, second = outlooks(fallen.store, found)
    assert first.starts == second.starts == 3
    assert first.since < 1.0
    # They lie at the end: slower than they fell, by far, and lower.
    for one in (first, second):
        assert one.last_speed.value < one.speed.value
        assert one.height.value < 0


def test_perturbed_starts_are_kept_apart_from_the_scene_itself(fallen: Done) -> None:
    store = fallen.store
    assert len(store.trials) == 6 + 6
    assert len(store.asked) == 6
    (text,) = (str(text) for name, text in PAGE.render(store).items() if name.endswith(".html"))
    assert "<td>start 2</td>" in text
    assert "<td>as it is</td>" in text
    assert "Perturbed starts" in text
