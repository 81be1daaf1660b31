"""A scene of one's own, carried out: verdicts, errors beside costs, words at the end, and a page as good as the others."""

import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.case.scene_file import own_case
from plumbline.harness.case.undropped import title_of
from plumbline.harness.cli.own_scene import closing_count, closing_words, waiting
from plumbline.harness.findings import tables
from plumbline.harness.findings.agreement.costs import best_price, best_setting
from plumbline.harness.findings.agreement.found import agreements, errors_of
from plumbline.harness.findings.agreement.happened import happenings, words_so_far
from plumbline.harness.findings.agreement.perturbed_starts import balances, outlooks
from plumbline.harness.findings.agreement.setting_causes import Turned, settings_turned
from plumbline.harness.findings.agreement.values import Side, Word
from plumbline.harness.findings.agreement.words import cut_words
from plumbline.harness.findings.columns import at
from plumbline.harness.findings.prices import Prices
from plumbline.harness.findings.selection import Wish, choose
from plumbline.harness.findings.selection.evidence import DECADES_OF_SPEED
from plumbline.harness.findings.selection.words import headline
from plumbline.harness.findings.sensor_readings.ideal import converged_readings
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.scene import Body, Imu, Scene, sphere_inertia
from plumbline.harness.scene.file import dump_toml, load
from plumbline.harness.store.journal import read_journal
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.study import Study, study_of
from plumbline.reports.html import report as html
from plumbline.reports.html.report import write_report
from plumbline.reports.page import pages
from plumbline.reports.pages.scene import PAGE, answers_of
from plumbline.reports.pictures import answer_pictures
from plumbline.reports.pictures.case_pictures import sight
from plumbline.reports.recordings import write_recordings
from tests.in_process import clocked_by, in_this_process
from tests.known_prices import LAWS, PLUGINS
from tests.links import dangling
from tests.own_limits import pendulum, pile

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
        assert not any(isinstance(value, list | dict) for value in row.values())


def test_errors_from_the_agreed_limit_have_prices(thrown: Done) -> None:
    prices = [price for price in Prices(thrown.store).prices if price.target == 1e-2]
    assert {price.engine for price in prices} == set(ENGINES)
    assert all(price.reached is not None for price in prices)
    assert len([price for price in prices if price.cheapest]) == 1


def test_what_is_bounded_at_the_coarsest_step_asked_for_is_a_price(thrown: Done) -> None:
    """An error that the coarsest step of both does not reach: nobody asked for a coarser one, so what that costs decides."""
    listed = {price.engine: price for price in Prices(thrown.store).prices if price.target == 1e-1}
    assert {price.verdict for price in listed.values()} == {"at most"}
    cheapest, dearest = sorted(listed, key=lambda name: at(listed[name], "reached.cost.value"))
    found = choose(thrown.store, Wish(max_error=1e-1, weights={"accuracy": 0.0}), draws=500)
    assert found.rank is not None
    assert [(place.engine, place.number) for place in found.rank.places] == [(cheapest, 1), (dearest, 2)]
    assert found.evidence.tracks == dict.fromkeys(listed, "tuned")  # both tracks cost the same, and the tuned one errs less
    ratio = at(listed[dearest], "reached.cost.value") / at(listed[cheapest], "reached.cost.value")
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
    (costs,) = [sentence for sentence in said if sentence.startswith("Times real time")]
    listed = {price.engine: price for price in Prices(thrown.store).prices if price.target == 1e-2}
    paced = sorted((at(price, "reached") for price in listed.values()), key=lambda met: met.cost.value)
    told = re.findall(r"([\d.e+]+) \((\w+), dt 1/(\d+) s\)", costs)
    assert told == [(f"{1 / met.cost.value:.3g}", met.at.track, f"{1 / met.at.dt:.4g}") for met in paced]
    for sentence in (*said, closing_count(thrown.store)):
        assert "passed" not in sentence
    assert closing_count(thrown.store) == "16 trials: 16 finite"


def test_the_page_is_as_good_as_the_others(thrown: Done, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(html, "pages", lambda: tuple(page for page in pages() if page.name in (PAGE.name, "case", "index")))
    write_recordings(thrown.store.folder)
    report = write_report(thrown.store.folder).index.parent
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
    assert re.search(
        r'class="figures"><span>[01]/1</span> <span>[\d.]+\N{MULTIPLICATION SIGN}</span> <span>[\d.]+ %</span>', index
    )
    assert "passed [cases]" not in index
    for told in (text, index):
        shown = re.sub(r"<script.*?</script>", "", told, flags=re.DOTALL)
        assert "agrees" in shown
        assert not re.search(r"[✓0-9] passed", shown)


QUESTIONS = ("Does it run?", "Do they agree?", "Who is off, and why?", "What does accuracy cost?", "What to set?")


def test_the_first_screen_answers_five_questions_in_order_before_anything_else(thrown: Done) -> None:
    (text,) = (str(text) for name, text in PAGE.render(thrown.store).items() if name.endswith(".html"))
    hero = text[text.index('<section class="hero') : text.index("</section>")]
    places = [hero.index(question) for question in QUESTIONS]
    assert places == sorted(places)
    for sentence in ("agree on one limit to the end", "Nobody."):
        assert sentence in hero
    for target in re.findall(r'<dt><a href="#([^"]+)"', hero):
        assert f'id="{target}"' in text
    # The cheapest at 1 %, with its track and step, is what to set.
    reached = [at(price, "reached") for price in Prices(thrown.store).prices if price.target == 1e-2]
    cheapest = min(reached, key=lambda met: met.cost.value)
    (agreement,) = agreements(thrown.store)
    best = best_setting(thrown.store, agreement)
    assert f", {cheapest.at.track} at dt 1/{1 / cheapest.at.dt:.4g} s: {1 / cheapest.cost.value:.3g} times real time" in best
    assert best in [sentence.removeprefix("Set: ") for sentence in closing_words(thrown.store)]


def test_what_to_set_is_a_track_that_agrees(thrown: Done) -> None:
    """A track that ends elsewhere, or nowhere, is no advice, however cheap it comes near the limit at one step."""
    (agreement,) = agreements(thrown.store)
    asked = [(at(p, "reached.cost.value"), p.engine) for p in Prices(thrown.store).prices if p.target == 1e-2]
    paces = {engine: f"{1 / cost:.3g} times real time" for cost, engine in sorted(asked)}
    cheapest, dearest = paces
    assert paces[cheapest] in best_setting(thrown.store, agreement)

    def lost(side: Side) -> Side:
        return replace(side, word="does not converge") if side.engine == cheapest else side

    left = replace(agreement, sides=tuple(map(lost, agreement.sides)))
    assert paces[dearest] in best_setting(thrown.store, left)


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


@pytest.fixture(scope="module")
def sensed(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """A pendulum with an inertial sensor on its bob, on two engines that people can deploy."""
    scene = replace(pendulum(), sensors=(Imu(name="imu", body="bob", rate=60.0),))
    asked = {"refine": Refinement(finest=1 / 960, further=0, members=0, turns=0), "timing": False, "tracks": ("tuned",)}
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        return carried_out(tmp_path_factory.mktemp("sensed"), scene, ("mujoco", "dart"), "sensed.toml", **asked)


def test_sensors_of_a_scene_of_ones_own_are_held_against_converged_readings(sensed: Done) -> None:
    """A gyroscope errs as the motion does: DART at its first step by the first order, MuJoCo by far less."""
    rows = {(row["engine"], row["channel"]): row for row in tables.table("sensors").rows(sensed.store)}
    assert rows.keys() == {(engine, channel) for engine in ("mujoco", "dart") for channel in ("accelerometer", "gyroscope")}
    for row in rows.values():
        assert row["reason"] == ""
        assert row["error_max"] is not None
    # Of a swing from 1 rad with 3 rad/s: a step of 1/240 s of the first order errs by some per cent of that at most.
    assert 0.0 < rows["mujoco", "gyroscope"]["error_max"] < rows["dart", "gyroscope"]["error_max"] < 0.1
    finer = converged_readings(sensed.store, sensed.case)
    time = finer["truth_stream:imu/time"]
    rate = np.linalg.norm(finer["truth_stream:imu/gyroscope_ideal"], axis=1)
    # Energy: w^2 moment / 2 is what its height gave, m g l (cos x - cos 1); at the end of a quarter swing that is all of it.
    moment = 1.0 + 0.4 * 0.4**2
    assert rate.max() == pytest.approx(math.sqrt(2 * 9.81 * (1 - math.cos(1.0)) / moment), rel=5e-3)  # samples miss the lowest
    assert time[-1] == pytest.approx(DURATION)


def test_readings_are_held_against_nothing_where_no_limit_is_agreed(fallen: Done) -> None:
    assert converged_readings(fallen.store, fallen.case) == {}


@pytest.fixture(scope="module")
def gripping(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """The cube of friction 5 among the examples, on MuJoCo alone: its default cone is a pyramid."""
    asked = {"refine": Refinement(finest=1 / 960, further=0, members=0, turns=3), "timing": False}
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        scene = load(Path(__file__).parents[2] / "examples" / "scenes" / "gripping_cube.toml")
        return carried_out(tmp_path_factory.mktemp("gripping"), scene, ("mujoco",), "gripping.toml", **asked)


def test_the_cause_of_a_cube_that_creeps_on_a_floor_it_grips_is_the_pyramid(gripping: Done) -> None:
    (agreement,) = agreements(gripping.store)
    turned = settings_turned(gripping.store, agreement)
    assert len(turned) == 3
    assert {(each.engine, each.track, each.towards) for each in turned} == {("mujoco", "default", "tuned")}
    (cause,) = [each for each in turned if each.cause]
    assert (cause.setting, cause.value) == ("cone", "elliptic")
    assert cause.closes > 0.9
    assert cause.before > 0.05
    for row in tables.table("causes").rows(gripping.store):
        assert row["closes"] == pytest.approx(1 - row["after"] / row["before"])
    said = " ".join(closing_words(gripping.store))
    assert "'cone' turned to elliptic alone closes" in said
    # What it adds beside is a list, and no cause.
    assert "Computed although the scene does not call for it: gyroscopic on MuJoCo default and MuJoCo tuned." in said


def test_a_side_that_agrees_with_the_limit_in_the_end_needs_no_cause(gripping: Done) -> None:
    """It was asked about at a coarse step, at which it lay apart: no sentence says that it ends away from where it ends."""
    (agreement,) = agreements(gripping.store)
    (default,) = [side for side in agreement.sides if side.track == "default"]

    def turned(word: Word) -> list[Turned]:
        sides = (replace(default, word=word),)
        return settings_turned(gripping.store, replace(agreement, sides=sides, limit=default.limit.value))

    assert {each.towards for each in turned("converges elsewhere")} == {"limit"}
    assert turned("agrees") == []


def test_each_verdict_on_the_first_screen_is_followed_by_its_cause(gripping: Done) -> None:
    """Two sides that are off, one of them with a cause: it stands behind that one's verdict and in front of the other's."""
    (agreement,) = agreements(gripping.store)
    off = tuple(replace(side, word="does not converge", why="planted") for side in agreement.sides)
    seen = sight(gripping.store, gripping.case)
    answers = {answer.title: answer for answer in answers_of(gripping.store, replace(agreement, sides=off), seen)}
    default, tuned = answers["Who is off, and why?"].sentences
    assert default.startswith("MuJoCo, default: does not converge")
    assert default.endswith("% of that.")
    assert tuned.startswith("MuJoCo, tuned: does not converge")


def test_settings_that_were_turned_are_no_sides_of_their_own(gripping: Done) -> None:
    (agreement,) = agreements(gripping.store)
    assert {side.track for side in agreement.sides} == {"default", "tuned"}
    assert len(gripping.store.asked) == 6
    assert len(gripping.store.trials) == 9


def test_what_happens_is_told_with_who_differs_in_it(fallen: Done) -> None:
    (agreement,) = agreements(fallen.store)
    groups = happenings(fallen.store, agreement)
    assert {side for group in groups for side in group.sides} == {("mujoco", "tuned"), ("dart", "tuned")}
    for group in groups:
        assert {event.body for event in group.events} <= {"box_0"}
        assert "passed through" not in {event.kind for event in group.events}
    assert closing_words(fallen.store)[1].startswith("What happens")


def test_a_first_look_tells_what_is_known_so_far_and_gives_no_verdict(
    gripping: Done, thrown: Done, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three steps of a ladder whose limits end apart say that they lie apart so far: smaller ones may bring them together."""
    for done in (gripping, thrown):
        records = list(read_journal(done.store.folder / "journal.jsonl").values())
        first = [each for each in records if each.trial in set(done.store.asked["trial"]) and each.dt > 1 / 1000]
        waiting({done.case: plugins.case(done.case)}, done.store.folder, None)._look(first)
        shown, said = capsys.readouterr()
        told = shown + said
        assert "no verdict yet" in shown
        assert not any(word in told for word in ("agrees", "converge", "limit", "camp", "known to"))
        assert "Smaller steps may change that." in said
    assert said.startswith("So far together to the end: ")

    (agreement,) = agreements(gripping.store)
    verdicts = ("converges elsewhere", "does not converge")
    sides = tuple(replace(side, word=word, distance=0.5) for side, word in zip(agreement.sides, verdicts, strict=True))
    (told, *_) = words_so_far(gripping.store, replace(agreement, sides=sides), {"mujoco": "MuJoCo"})
    apart_and_open = r"So far apart, by 50 % .*at most: MuJoCo \(default\); not settled yet: MuJoCo \(tuned\)\. Smaller .*"
    assert re.fullmatch(apart_and_open, told)


def test_each_of_the_five_answers_has_its_picture(thrown: Done) -> None:
    (text,) = (str(text) for name, text in PAGE.render(thrown.store).items() if name.endswith(".html"))
    hero = text[text.index('<section class="hero') : text.index("</section>")]
    for question, after in zip(QUESTIONS, (*QUESTIONS[1:], "Verdicts"), strict=True):
        answer = hero[hero.index(question) : hero.index(after)]
        assert answer.count("<svg") == answer.count('role="img"') == answer.count("<figcaption>") == 1, question
        assert re.search(r"<(path|circle|rect) [^>]*#[0-9a-f]{6}", answer), question  # something in an engine's colour


def test_the_picture_of_runs_has_a_mark_for_each_step_and_a_symbol_where_there_is_no_answer(gripping: Done) -> None:
    (agreement,) = agreements(gripping.store)
    default, tuned = agreement.sides
    lost = replace(default.limit.rungs[0], run=None, status="diverged")
    cut = replace(default, limit=replace(default.limit, rungs=(lost, *default.limit.rungs[1:])))
    drawn = answer_pictures.runs_by_step(gripping.store, replace(agreement, sides=(cut, tuned)))
    assert drawn is not None
    assert drawn.rows is not None
    assert [[spot.symbol for spot in line.spots] for line in drawn.rows.lines] == [["∞", "", ""], ["", "", ""]]
    assert [words for _, words in drawn.rows.ticks] == ["1/240 s", "1/960 s"]


def test_the_picture_of_causes_shows_what_each_setting_closes_and_without_any_how_far_each_is_off(gripping: Done) -> None:
    (agreement,) = agreements(gripping.store)
    turned = settings_turned(gripping.store, agreement)
    drawn = answer_pictures.causes(gripping.store, agreement, turned)
    assert drawn is not None
    assert drawn.rows is not None
    assert len(drawn.rows.lines) == len(turned)
    first, *others = drawn.rows.lines
    assert first.label == "MuJoCo cone"
    assert first.strong
    assert not any(line.strong for line in others)
    assert first.bar is not None
    assert drawn.rows.limit is not None
    assert first.bar > drawn.rows.limit  # it closes more than the four fifths that make a cause
    off = answer_pictures.causes(gripping.store, agreement, [])
    assert off is not None
    assert off.rows is not None
    assert [line.label for line in off.rows.lines] == ["MuJoCo default", "MuJoCo tuned"]


def test_the_picture_of_what_to_set_ranks_by_speed_and_marks_what_is_advised(thrown: Done) -> None:
    (agreement,) = agreements(thrown.store)
    best = best_price(thrown.store, agreement)
    assert best is not None
    drawn = answer_pictures.speeds(thrown.store, agreement, best)
    assert drawn is not None
    assert drawn.rows is not None
    places = [line.spots[0].x for line in drawn.rows.lines]
    assert places == sorted(places, reverse=True)
    (strong,) = [line for line in drawn.rows.lines if line.strong]
    assert strong.words.endswith(f"1/{1 / at(best, 'reached.at.dt'):.4g} s")
    nobody = answer_pictures.speeds(thrown.store, replace(agreement, case="another"), None)
    assert nobody is not None
    assert nobody.rows is not None
    assert "smallest error" in nobody.rows.caption


def test_engines_whose_limits_are_one_are_shown_as_they_move(gripping: Done) -> None:
    """No distance has a logarithm there: the picture is that of all runs over one another."""
    (agreement,) = agreements(gripping.store)
    alone = replace(agreement, sides=agreement.sides[:1])
    motion = sight(gripping.store, gripping.case).overview
    drawn = answer_pictures.distances(gripping.store, alone, motion)
    assert drawn is not None
    assert drawn.panel is motion is not None


def test_verdicts_on_ladders_that_time_cut_short_say_so(gripping: Done) -> None:
    """The ladders were to come down to 1/960 s, and did; had it been 1/3840 s, the verdicts would be those of three steps."""
    (agreement,) = agreements(gripping.store)
    assert agreement.finest == pytest.approx(1 / 960)
    assert not any("Time ended" in sentence for sentence in closing_words(gripping.store))
    default, tuned = agreement.sides
    shorter = replace(default, limit=replace(default.limit, rungs=default.limit.rungs[:2]))
    (sentence,) = cut_words(replace(agreement, sides=(shorter, tuned)), {"mujoco": "MuJoCo"})
    assert sentence.startswith("Time ended before all steps were run on MuJoCo (default): smaller ones may change")
    seen = sight(gripping.store, gripping.case)
    answers = {answer.title: answer for answer in answers_of(gripping.store, replace(agreement, finest=1 / 3840), seen)}
    assert answers["Do they agree?"].sentences[1].startswith("Time ended before all steps were run on MuJoCo: ")
    # A limit that is not known to the end is given finer steps than one that is.
    unknown = replace(tuned, limit=replace(tuned.limit, kind="does not converge"))
    assert replace(agreement, sides=(default, unknown), finest_unknown=1 / 3840).cut_short == (unknown,)
    lost = replace(default.limit.rungs[-1], run=None, status="diverged")
    ended = replace(default, limit=replace(default.limit, rungs=(*default.limit.rungs[:2], lost)))
    assert replace(agreement, sides=(ended,)).cut_short == ()


def test_a_track_that_diverged_is_told_though_its_engine_runs_on_the_other(gripping: Done) -> None:
    (agreement,) = agreements(gripping.store)
    default, tuned = agreement.sides
    lost = replace(default, word="diverged", why="at every step")
    seen = sight(gripping.store, gripping.case)
    first, *_ = answers_of(gripping.store, replace(agreement, sides=(lost, tuned)), seen)
    assert first.sentences == ("Runs on MuJoCo.", "MuJoCo, default: diverged (at every step).")
    both = (lost, replace(tuned, word="diverged", why="at every step"))
    first, *_ = answers_of(gripping.store, replace(agreement, sides=both), seen)
    assert first.sentences == ("No engine runs it.", "MuJoCo: diverged (at every step).")
