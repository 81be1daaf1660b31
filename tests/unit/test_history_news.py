"""What nights tell: planted changes with what shows them, what is acknowledged, what was waited for, and the gate."""

import json
import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.findings.changes.words import command, sentence
from plumbline.harness.findings.vendor_findings import shelf
from plumbline.harness.history.folder import opened, stamp_of
from plumbline.harness.history.identity import Named, acknowledge, change_id
from plumbline.harness.history.night_policy import NightWish
from plumbline.harness.history.regressions import read_trends
from plumbline.harness.history.retention import problems_of
from plumbline.harness.history.sentences import unanswered_in_short, worse_in_short
from plumbline.harness.run import campaign
from plumbline.harness.run.interrupt import TimeIsUp, naming
from plumbline.harness.store.journal import Journal, read_journal
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import write_json
from plumbline.harness.study.trial import Trial
from tests.conftest import Command
from tests.nights import CELLS, STUDY, Fault, asked, drawn, night, one_ulp_off, planted, rougher
from tests.synthetic_history import priced


@pytest.fixture
def root(first_night: Path, tmp_path: Path) -> Path:
    """A copy of a history with one night."""
    return Path(shutil.copytree(first_night, tmp_path / "h"))


def few() -> NightWish:
    """The first experiment of the study alone: half of its answers."""
    return asked(replace(STUDY, experiments=STUDY.experiments[:1]))


def test_a_second_night_recalls_what_is_known_and_tells_nothing(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(monkeypatch, 0.0)
    with planted() as computed:
        second, news, account = night(root)
    assert computed == []
    assert account["recalled"] == CELLS
    assert account["clocked"] == CELLS
    assert news is not None
    assert not [row for row in news.changes.rows if row.sense in ("worse", "better")]
    assert news.changes.matched == news.changes.same == CELLS
    recalled = second.store().trials
    assert set(recalled["recalled"]) - {""} == {opened(root).nights()[0].stamp}
    assert [*problems_of(opened(root))] == []


def test_a_slower_engine_is_told_with_how_much_and_what_shows_it(root: Path) -> None:
    with planted(Fault(engine="reference", price=1.2)):
        _, news, _ = night(root)
    assert news is not None
    worse = news.regressions(("reference",))
    assert {(row.kind, row.engine) for row in news.changes.rows if row.regression} == {("price", "reference")}
    # Samples of 1 % noise, five of them: a median is off by less than 2 %.
    assert all(row.ratio == pytest.approx(1.2, rel=0.02) for row in worse)
    assert {row.case for row in worse} >= {"flight_projectile", "friction_stop"}
    one = next(row for row in worse if row.case == "friction_stop")
    assert "friction_stop on reference" in sentence(one)
    assert "--engine reference --case friction_stop" in command(one, news.changes)


@pytest.mark.slow  # the night of the command below has more friction too
def test_more_friction_is_told_of_the_case_that_has_any(root: Path) -> None:
    with planted(Fault(engine="reference", scene=rougher)):
        _, news, _ = night(root)
    assert news is not None
    worse = news.regressions(("reference",))
    assert {(row.case, row.engine) for row in worse} == {("friction_stop", "reference")}
    assert {row.kind for row in worse} <= {"verdict", "error"}
    assert all(command(row, news.changes).startswith("plumbline reproduce") for row in worse)


def test_one_ulp_under_the_same_digest_is_another_answer_and_then_everything_of_that_engine_is_computed(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn(monkeypatch, 1.0)
    with planted(Fault(engine="reference", state=one_ulp_off, known=False)):
        last, news, account = night(root, few())
    assert news is not None
    told = [row for row in news.changes.rows if row.kind in ("digest", "verdict", "error", "price", "limit")]
    assert {(row.kind, row.engine, row.sense) for row in told} == {("digest", "reference", "worse")}
    assert account["disagreements"] == len(told) == CELLS // 4
    assert "same digest, another answer" in sentence(told[0])
    drawn(monkeypatch, 0.0)
    with planted() as computed:
        _, later, _ = night(root, few())
    # What it answered before that night is not trusted; what it answered in it is.
    assert computed == []
    assert later is not None
    assert {record.recalled for record in read_journal(opened(root).nights()[-1].folder / "journal.jsonl").values()} >= {
        last.stamp
    }


@pytest.mark.slow
def test_one_ulp_under_another_digest_is_told_as_no_worse(root: Path) -> None:
    with planted(Fault(engine="reference", state=one_ulp_off)):
        _, news, _ = night(root)
    assert news is not None
    told = {(row.kind, row.sense, row.engine) for row in news.changes.rows if row.kind in ("error", "verdict", "digest")}
    assert told == {("error", "within tolerance", "reference")}
    assert news.regressions(("reference",)) == ()


def test_what_is_acknowledged_is_not_told_again(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(monkeypatch, 1.0)
    fault = Fault(engine="mujoco", state=one_ulp_off, known=False)
    with planted(fault):
        _, _, account = night(root, few())
    for row in account["told"]:
        acknowledge(opened(root), Named.told(row), "a new C library")
    with planted():
        _, news, _ = night(root, few())
    assert news is not None
    assert not [row for row in news.changes.rows if row.kind == "digest"]
    assert {row.kind for row in news.acknowledged} == {"digest"}
    assert all(change_id(row, account["stamp"]) in {told["id"] for told in account["told"]} for row in news.acknowledged)


FILE = """
name = "few"
[[experiments]]
name = "look"
cases = ["flight_projectile", "friction_stop"]
samples = 3
"""


def test_the_command_ends_with_one_where_a_gated_engine_is_worse_and_gives_the_summary_to_who_is_notified(
    tmp_path: Path, printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each finding about an engine is a process a night: one of them in one night shows that nights ask.
    finding = next(each for each in shelf() if each.engine == "mujoco")
    on_the_shelf = iter([(), (finding,), ()])
    monkeypatch.setattr("plumbline.harness.findings.vendor_findings.shelf", lambda: next(on_the_shelf))
    study, root, mail = tmp_path / "few.toml", tmp_path / "h", tmp_path / "mail"
    study.write_text(FILE)
    words = ["nightly", "--history", root, "--study", study, "--engine", "mujoco", "--no-report"]
    with planted():
        began = printed(*words)
    assert (began.returncode, began.stderr) == (0, "")
    assert "4 answers, 0 recalled, 4 computed" in began.stdout
    with planted(Fault(engine="mujoco", scene=rougher)):
        ended = printed(*words, "--gate", "mujoco", "--notify", f"cat > {mail}")
    assert ended.returncode == 1
    assert "gate: friction_stop on mujoco" in ended.stdout
    assert "plumbline reproduce" in ended.stdout
    night = opened(root).nights()[-1]
    assert mail.read_bytes() == (night.folder / "changes" / "summary.md").read_bytes()
    assert "friction_stop on mujoco" in mail.read_text()
    assert {path.name for path in (night.folder / "changes").iterdir()} == {
        "summary.md", "junit.xml", "changes.json", "asv.json", "bencher.json", "badge.svg", "what-changed.html", "style",
    }  # fmt: skip
    assert [row["name"] for row in night.plan["findings"]] == [finding.name]
    assert "accuracy" in (night.folder / "night.log").read_text()
    listed = printed("history", root, "--json")
    assert [row["worse"] > 0 for row in json.loads(listed.stdout)] == [False, True]
    assert printed("verify", root).returncode == 0
    with planted(Fault(engine="mujoco", scene=rougher)):
        settled = printed(*words, "--gate", "mujoco")
    # It is told once, by the night that saw it first; from then on it stands below, until somebody acknowledges it.
    assert settled.returncode == 0
    assert "Still worse since an earlier night" in (opened(root).nights()[-1].folder / "changes" / "summary.md").read_text()


def drifting(root: Path, study: Path, nights: int) -> None:
    """In place of the one night of a history: so many, a day apart, whose prices of the reference engine become a tenth dearer
    over thirty of them, with 2 % noise; everything else is as it was."""
    first, rng = opened(root).nights()[0], np.random.default_rng(21)
    records = read_journal(first.folder / "journal.jsonl").values()
    for age in range(nights):
        folder = opened(root).night(stamp_of(first.began - timedelta(days=nights - age))).folder
        shutil.copytree(first.folder, folder, ignore=shutil.ignore_patterns("*.parquet", "journal.jsonl"))
        write_json(folder / "night.json", {**first.plan, "stamp": folder.name})
        journal = Journal(folder)
        for record in records:
            drift = 1 + 0.1 * min(max((age - 2) / 30, 0.0), 1.0) if record.engine == "reference" else 1.0
            journal.append(priced(record, 1e-5 * drift * float(np.exp(rng.normal(0, 0.02))), 1e-3))
        journal.close()
    shutil.rmtree(first.folder)


def test_of_many_things_that_got_worse_those_of_an_engine_as_a_whole_come_first_and_each_id_once() -> None:
    cells = [("stack_tower", str(number // 3)) for number in range(90)]
    rows = [
        {"id": name, "case": case, "engine": "dart", "regression": True, "sentence": f"{case} {name}.", "command": "see"}
        for case, name in [*cells, ("", "whole")]
    ]
    better = dict(rows[0], id="better", regression=False)
    lines = worse_in_short([better, *rows], ["dart"])
    assert lines[:4] == ["gate:  whole.", "    see  (id whole)", "gate: stack_tower 0.", "    see  (id 0; 2 more of it)"]
    assert lines[-1] == "… and 6 more, in summary.md and changes.json"
    assert len(lines) == 2 * 25 + 1
    assert worse_in_short([better], ["dart"]) == []


def test_what_a_night_waited_for_in_vain_is_named_and_holds_up_nothing_the_next_night(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An engine sleeps over one case until time is up."""
    monkeypatch.setattr("plumbline.harness.history.night_policy.AGAIN", 0.0)
    with planted() as computed:
        sound = campaign.run_isolated

        def asleep(trials: Sequence[Trial], folder: Path, workers: int) -> Iterator[Record]:
            for trial in trials:
                if (trial.experiment.name, trial.case, trial.engine) == ("look", "flight_projectile", "mujoco"):
                    with naming([(trial, time.monotonic() - 30.0)]):
                        raise TimeIsUp
                yield from sound([trial], folder, workers)

        monkeypatch.setattr(campaign, "run_isolated", asleep)
        _, _, first = night(tmp_path / "h")
        before = len(computed)
        _, _, second = night(tmp_path / "h")
    for account in (first, second):
        (waited,) = account["unanswered"]
        assert (waited["case"], waited["engine"], round(waited["seconds"])) == ("flight_projectile", "mujoco", 30)
        assert "flight_projectile mujoco/" in unanswered_in_short(account["unanswered"])
    assert ("look", "friction_stop") in {(row["experiment"], row["case"]) for row in first["left_out"]}
    assert [(row["experiment"], row["case"]) for row in second["left_out"]] == [("look", "flight_projectile")]
    # All but the two tracks of the engine that sleeps, each once over both nights: a night keeps what it has.
    assert len(computed) == len(set(computed)) == CELLS - 2
    assert before < len(computed)


@pytest.mark.slow
def test_a_drift_that_no_single_night_shows_is_told_once_ends_with_one_and_is_silenced_everywhere_by_one_word(
    tmp_path: Path, printed: Command
) -> None:
    study, root = tmp_path / "few.toml", tmp_path / "h"
    study.write_text(FILE)
    words = ["nightly", "--history", root, "--study", study, "--engine", "mujoco", "--engine", "reference", "--no-report"]
    with planted():
        assert printed(*words).returncode == 0
    drifting(root, study, 33)

    def tonight() -> tuple[int, dict[str, Any], str]:
        with planted(Fault(engine="reference", price=1.1, known=False)):
            code = printed(*words, "--gate", "reference").returncode
        last = opened(root).nights()[-1]
        return code, dict(last.plan), (last.folder / "changes" / "summary.md").read_text()

    code, plan, text = tonight()
    assert code == 1
    told = [row for row in plan["told"] if row["regression"]]
    assert {(row["kind"], row["engine"], row["case"]) for row in told} == {
        ("price", "reference", case) for case in ("flight_projectile", "friction_stop")
    }
    assert all("over all nights, on this level since" in row["sentence"] for row in told)
    assert all("plumbline run" in row["command"] for row in told)
    assert f"Gate (reference): {len(told)} regressions (" in text
    assert {one.id for one in read_trends(opened(root)).standing()} == {row["id"] for row in told}
    code, plan, text = tonight()
    assert (code, plan["told"]) == (0, [])
    assert "Still worse since an earlier night (2)" in text
    for row in told:
        assert printed("history", "ack", row["id"], "--note", "known", "--history", root).returncode == 0
    code, plan, text = tonight()
    assert (code, plan["told"]) == (0, [])
    assert "Still worse" not in text
    assert read_trends(opened(root)).standing() == ()
