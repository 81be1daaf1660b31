"""Ways past the gate of a night: narrowed nights, lost answers, prices that could not be judged."""

import json
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.cli import nightly_command
from plumbline.harness.history import night_policy
from plumbline.harness.history.blocks import last_to_see
from plumbline.harness.history.changes_since import EARLIER, News
from plumbline.harness.history.folder import opened, stamp_of
from plumbline.harness.history.regressions import read_trends
from plumbline.harness.history.retention import prune, pruning
from plumbline.harness.history.sentences import open_since, reasons
from plumbline.harness.run import campaign
from plumbline.harness.run.timing_protocol import summarise
from plumbline.harness.store.machine_fingerprint import fingerprint
from plumbline.harness.store.record import Record, Sample, Timing
from plumbline.harness.store.store import write_json
from plumbline.harness.study import plugins
from plumbline.harness.study.trial import Trial
from tests.conftest import Command
from tests.in_process import steps_of_run
from tests.nights import CELLS, NONE, STUDY, Fault, asked, drawn, night, planted, rougher
from tests.unit.test_history_news import FILE

ROUGHER = Fault(engine="reference", scene=rougher)
LOOK = replace(STUDY, experiments=STUDY.experiments[:1])


@pytest.fixture
def root(first_night: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of a history with one night of both engines; nothing that is known is computed again."""
    drawn(monkeypatch, 0.0)
    return Path(shutil.copytree(first_night, tmp_path / "h"))


def worse(news: News | None) -> set[tuple[str, str]]:
    """Kinds and cases of what a gate on our engine sees."""
    assert news is not None
    return {(row.kind, row.case) for row in news.regressions(("reference",))}


def narrowed_by_engine() -> Any:
    return asked(LOOK, engines=("mujoco",))


def narrowed_by_case() -> Any:
    return asked(replace(LOOK, experiments=(replace(LOOK.experiments[0], cases=("flight_projectile",)),)))


def narrowed_by_track() -> Any:
    return asked(replace(LOOK, experiments=(replace(LOOK.experiments[0], tracks=("default",)),)))


@pytest.mark.parametrize("narrowed", [narrowed_by_engine, narrowed_by_case, narrowed_by_track])
def test_a_night_that_was_narrowed_hides_no_fault_from_the_next(root: Path, narrowed: Callable[[], Any]) -> None:
    with planted():
        night(root, narrowed())
    with planted(ROUGHER):
        _, news, _ = night(root, asked(LOOK))
    assert {case for _, case in worse(news)} == {"friction_stop"}
    assert news is not None
    tracks = {row.track for row in news.changes.rows if row.case == "friction_stop" and row.sense == "worse"}
    assert tracks == {"default", "tuned"}


def test_nights_of_another_study_hide_no_fault_from_the_next_of_this_one(root: Path) -> None:
    with planted():
        for _ in range(EARLIER + 1):
            _, news, _ = night(root, asked(replace(LOOK, name="other")))
    first, *others = opened(root).nights()
    assert pruning(opened(root), keep_nights=1).standing == (first,)
    assert len(others) == EARLIER + 1
    assert news is not None  # with the night before, of the same study
    with planted(ROUGHER):
        _, news, _ = night(root, asked(LOOK))
    assert {case for _, case in worse(news)} == {"friction_stop"}


def test_a_night_of_questions_that_none_before_asked_says_that_nothing_was_seen(root: Path) -> None:
    with planted(ROUGHER):
        other_steps = replace(LOOK, name="other", experiments=(replace(LOOK.experiments[0], dt=(1 / 120,)),))
        _, news, account = night(root, asked(other_steps))
    assert news is None
    assert reasons(news, account, ("reference",), 0.9) == ["not judged: nothing of it was seen before"]


def test_of_a_night_of_an_older_version_the_journal_says_which_engines_it_saw(root: Path) -> None:
    with planted():
        night(root, narrowed_by_engine())
    for each in opened(root).nights():
        blocks = [{name: value for name, value in row.items() if name != "saw"} for row in each.plan["blocks"]]
        write_json(each.folder / "night.json", {**each.plan, "blocks": blocks})
    with planted(ROUGHER):
        _, news, _ = night(root, asked(LOOK))
    assert {case for _, case in worse(news)} == {"friction_stop"}


def test_the_only_night_of_an_engine_stays(root: Path) -> None:
    with planted():
        night(root, asked(engines=("mujoco",)))
    history = opened(root)
    prune(what := pruning(history, keep_nights=1))
    assert what.nights == ()
    assert what.standing == history.nights()[:1]
    assert last_to_see(history.whole_nights()) == {*history.nights()}
    with planted():
        night(root)
    assert pruning(history, keep_nights=1).nights == history.nights()[:2]


@contextmanager
def crashed(engine: str, fault: Fault = NONE) -> Iterator[None]:
    """Let every answer of an engine be a crash, by another adapter than before."""
    with planted(replace(fault, engine=engine, price=1.0 + 1e-9)):
        answers = campaign.run_isolated

        def dead(*arguments: Any) -> Iterator[Record]:
            for record in answers(*arguments):
                mine = record.engine == engine
                lost = replace(record, status="crashed", reason="signal 11", measurements=(), trajectory_hash=None, warnings=())
                yield lost if mine else record

        campaign.run_isolated = dead
        yield


def rows_of(news: News | None, *kinds: str) -> list[tuple[str, str, str, str]]:
    assert news is not None
    return [(row.kind, row.sense, row.case, row.track) for row in news.changes.rows if row.kind in kinds]


KINDS = ("verdict", "error", "warning", "price", "limit", "determinism", "trials")


def test_a_crash_is_one_thing_worse_for_each_answer_its_repair_one_better_and_nothing_stands_after_it(root: Path) -> None:
    what = asked(LOOK)
    with crashed("mujoco"):
        _, news, first = night(root, what)
    answers = [(case, track) for case in LOOK.experiments[0].cases for track in ("default", "tuned")]
    assert sorted(rows_of(news, *KINDS)) == [("verdict", "worse", *answer) for answer in answers]
    assert all("lost: crashed" in row["sentence"] for row in first["told"])
    with crashed("mujoco"):
        _, news, second = night(root, what)
    assert rows_of(news, *KINDS) == []
    plans = [each.plan for each in opened(root).nights()]
    assert len(open_since(plans, {}, tonight=second["told"])) == 4
    with planted():
        _, news, third = night(root, what)
    assert sorted(rows_of(news, *KINDS)) == [("verdict", "better", *answer) for answer in answers]
    assert open_since(plans, {}, tonight=third["told"]) == []
    assert [one.state for one in read_trends(opened(root)).regressions] == ["mended"] * 4


def test_a_fault_does_not_hide_behind_the_crash_before_it(root: Path) -> None:
    what = asked(LOOK)
    with crashed("reference"):
        night(root, what)
    with planted(ROUGHER):
        _, news, _ = night(root, what)
    assert {("verdict", "worse", "friction_stop"), ("verdict", "better", "friction_stop")} & {
        row[:3] for row in rows_of(news, "verdict")
    }
    assert {case for _, case in worse(news)} == {"friction_stop"}
    assert news is not None
    assert news.changes.judged_of(("reference",)).share == 1.0
    later = [one for one in read_trends(opened(root)).regressions if one.first.after != "crashed"]
    assert {one.first.case for one in later} == {"friction_stop"}
    plans = [each.plan for each in opened(root).nights()]
    assert {row["case"] for row in open_since(plans, {})} == {"friction_stop"}


def test_an_engine_that_crashes_from_its_first_night_on_fails_its_gate_every_night(
    tmp_path: Path, printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plumbline.harness.findings.vendor_findings.shelf", tuple)
    study = tmp_path / "few.toml"
    study.write_text(FILE)
    words = ["nightly", "--history", tmp_path / "h", "--study", study, "--no-report", "--gate", "mujoco"]
    for _ in range(2):
        with crashed("mujoco"):
            done = printed(*words, "--engine", "mujoco", "--engine", "reference")
        assert done.returncode == 1
        assert "outcomes: mujoco 4 crashed; reference" in done.stdout
        assert "gate: no answer of this engine: mujoco 4 crashed" in done.stdout
    listed = json.loads(printed("history", tmp_path / "h", "--json").stdout)
    assert ["mujoco 4 crashed" in row["outcomes"] for row in listed] == [True, True]


def restless(slow: Mapping[str, float], times: list[str], calm_after: int = 10**9) -> Callable[..., Iterator[Timing]]:
    """A clock under which our prices stray by half, some so many times as dear; calm once it was asked so often.

    Args: times: takes down each trial that is clocked.
    """

    def clocks(trials: Sequence[Trial], _folder: Path, **_how: object) -> Iterator[Timing]:
        for trial in trials:
            calm = trial.engine != "reference" or times.count(trial.trial) >= calm_after
            dear = 1.0 if calm and calm_after < 10**9 else slow.get(trial.case, 1.0) if trial.engine == "reference" else 1.0
            run, strays = steps_of_run(trial), (1.0, 1.0, 1.0) if calm else (1.0, 0.8, 1.25)
            times.append(trial.trial)
            samples = [
                Sample(process=0, block=k, steps=run, cpu=run * 1e-5 * dear * stray, wall=1.0, canary=1e-3, switches=0, run=run)
                for k, stray in enumerate(strays)
            ]
            yield summarise(trial, samples)

    return clocks


def test_what_could_not_be_judged_is_said_and_an_unstable_price_that_is_dearer_is_named_as_unconfirmed(
    tmp_path: Path, printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plumbline.harness.findings.vendor_findings.shelf", tuple)
    study = tmp_path / "few.toml"
    study.write_text(FILE)
    words = ["nightly", "--history", tmp_path / "h", "--study", study, "--no-report", "--gate", "reference"]
    words += ["--engine", "mujoco", "--engine", "reference"]
    for slow in ({}, {"friction_stop": 3.1}):
        with planted():
            campaign.clock_group = restless(slow, [])
            done = printed(*words)
        assert done.returncode == 0
    assert done.stdout.startswith("accuracy: all judged; prices: 0 of 4 judged\n")
    assert "friction_stop on reference (tuned)" in done.stdout
    assert "unconfirmed, its timing is unstable: 3.1 times the CPU time" in done.stdout
    assert "--engine reference --case friction_stop --out build/again" in done.stdout
    changes = opened(tmp_path / "h").nights()[-1].folder / "changes"
    assert "no regression (accuracy: all judged; prices: 0 of 4 judged)" in (changes / "summary.md").read_text()
    assert "prices: 0 of 4 judged" in (changes / "junit.xml").read_text()
    first, second = (str(each.folder) for each in opened(tmp_path / "h").nights())
    assert "prices: 4 of 8 judged" in printed("diff", first, second).stdout
    compared = printed("diff", first, second, "--gate", "reference", "--judged", "0.9")
    assert compared.returncode == 1
    assert "gate: not judged: less than 0.9 of it could be" in compared.stderr
    with planted():
        campaign.clock_group = restless({}, [])
        done = printed(*words, "--judged", "0.9")
    assert done.returncode == 1
    assert "gate: not judged: less than 0.9 of it could be (accuracy: all judged; prices: 0 of 4 judged)" in done.stdout


def test_an_unstable_price_that_is_dearer_is_measured_again_the_same_night(root: Path) -> None:
    times: list[str] = []
    with planted():
        campaign.clock_group = restless({"friction_stop": 3.1}, times, calm_after=1)
        _, news, _ = night(root, asked(LOOK))
    assert sorted(Counter(times).values()) == [1] * 4 + [2] * 4  # friction_stop alone, on both engines side by side
    assert news is not None
    assert [row for row in news.changes.rows if row.kind == "price"] == []


def test_a_night_takes_versions_of_an_engine_as_a_run_does(
    tmp_path: Path, printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = tmp_path / "few.toml"
    study.write_text(FILE)
    words = ["nightly", "--history", tmp_path / "h", "--study", study, "--no-report"]
    assert "reference has no versions of its own" in printed(*words, "--engine", "reference==1.0").stderr
    seen: list[tuple[str, ...]] = []

    def chosen(texts: Sequence[str], _agreed: bool) -> Mapping[str, Any]:
        seen.append(tuple(texts))
        return {name: plugins.adapter("mujoco") for name in texts}

    monkeypatch.setattr("plumbline.harness.cli.nightly_command.chosen_engines", chosen)
    done = printed(*words, "--engine", "mujoco==3.3.0", "--gate", "mujoco")
    assert seen == [("mujoco==3.3.0",)]
    assert "'mujoco' is not asked, expected some of mujoco==3.3.0" in done.stderr


def test_a_study_of_fewer_steps_hides_no_fault_at_the_others(root: Path) -> None:
    ladder = STUDY.experiments[1]
    friction = replace(ladder, cases=("friction_stop",))
    fewer = replace(friction, dt=(1 / 60,))
    with planted():
        night(root, asked(replace(STUDY, experiments=(friction,))))
        night(root, asked(replace(STUDY, experiments=(fewer,))))
    with planted(ROUGHER):
        _, news, _ = night(root, asked(replace(STUDY, experiments=(friction,))))
    assert news is not None
    assert {round(1 / row.dt) for row in news.regressions(("reference",))} == {60, 240}


def test_what_asks_something_else_than_before_counts_as_not_judged(root: Path) -> None:
    """A case whose parameters change in the night of a fault: nothing is worse, and not all was judged."""
    plain = plugins.case
    faster = replace(plain("friction_stop"), parameters=replace(plain("friction_stop").parameters, speed=2.5))  # type: ignore[type-var]
    with planted(ROUGHER), pytest.MonkeyPatch.context() as patch:
        patch.setattr(plugins, "case", lambda name: faster if name == "friction_stop" else plain(name))
        _, news, account = night(root)
    assert news is not None
    judged = news.changes.judged_of(("reference",))
    assert (judged.answers, judged.all_answers, judged.prices, judged.all_prices) == (6, 8, 6, 8)
    assert reasons(news, account, ("reference",), 0.9)
    assert not reasons(news, account, ("reference",), 0.0)


def test_a_run_that_was_put_among_the_nights_hides_nothing(root: Path, tmp_path: Path) -> None:
    """As merged shards are: with the same fault, under the name of a later night, and without what makes it one."""
    first = opened(root).nights()[0]
    shutil.copytree(root, tmp_path / "other")
    with planted(ROUGHER):
        other, _, _ = night(tmp_path / "other")
    put = opened(root).night(stamp_of(first.began + timedelta(seconds=1))).folder
    shutil.copytree(other.folder, put, ignore=shutil.ignore_patterns("night.json"))
    with planted(ROUGHER):
        _, news, _ = night(root)
    assert worse(news) == {("verdict", "friction_stop")}


def test_prices_are_those_of_the_last_night_on_this_machine(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch, planted(Fault(engine="reference", price=1.6)):
        for module in (campaign, night_policy):
            patch.setattr(module, "fingerprint", lambda: {**fingerprint(), "processor": "another"})
        _, elsewhere, _ = night(root)
    assert elsewhere is not None
    assert worse(elsewhere) == set()
    assert elsewhere.changes.judged_of(("reference",)).prices == 0
    with planted(Fault(engine="reference", price=1.2)):
        _, news, _ = night(root)
    assert news is not None
    (whole,) = (row for row in news.regressions(("reference",)) if not row.case)
    assert whole.ratio == pytest.approx(1.2, rel=0.02)


def test_what_is_asked_under_other_names_is_compared_by_what_it_asks(root: Path) -> None:
    renamed = replace(STUDY, name="other", experiments=tuple(replace(e, name=f"{e.name}_2") for e in STUDY.experiments))
    with planted(ROUGHER):
        _, news, _ = night(root, asked(renamed))
    assert worse(news) == {("verdict", "friction_stop")}
    assert news is not None
    assert news.changes.matched == CELLS


def test_a_gate_takes_an_engine_by_the_words_of_the_option_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nightly_command, "chosen_engines", lambda *_: {"mujoco 3.3.0": plugins.adapter("mujoco")})
    words: dict[str, Any] = {"engines": ("mujoco==3.3.0",), "globs": ("flight_projectile",), "keep": "none", "agreed": False}
    for gated in ("mujoco==3.3.0", "mujoco 3.3.0"):
        assert nightly_command._asked(study="quick", gated=(gated,), **words).gated == ("mujoco 3.3.0",)


def test_a_gate_on_an_engine_that_a_budget_left_out_altogether_fails(root: Path) -> None:
    """Else a machine that is always too slow would pass every night."""
    with planted():
        _, news, account = night(root, asked(LOOK, budget=0.01))
    assert news is None
    assert account["outcomes"] == {}
    assert reasons(news, account, ("reference",), 0.0) == ["no answer of this engine: reference, time was up before"]
