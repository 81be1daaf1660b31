"""Every number of the first page leads by its links, in two clicks, to its trial, and runs again by the command shown there."""

import html
import json
import random
import re
import shlex
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.findings.causes import margins
from plumbline.harness.run import isolated
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import run_trial
from plumbline.reports.tables.verdicts import margin_words
from plumbline.reports.words.text import TIMES, amount
from tests.in_process import in_this_process
from tests.needs import BULLET

Command = Callable[..., Any]

STUDY = """
name = "traced"
[[experiments]]
name = "ladder"
cases = {cases}
engines = {engines}
tracks = ["default", "tuned"]
timing = {timing}
"""
LINK = re.compile(r'<a class="traced[^"]*" href="([^"]+)"[^>]*>(.*?)</a>', re.DOTALL)


def words(element: str) -> str:
    return " ".join(html.unescape(re.sub(r"<svg.*?</svg>|<[^>]+>", " ", element)).split())


def numbers(report: Path) -> list[tuple[str, str]]:
    """Address and text of each number of the first page that leads somewhere."""
    links = LINK.findall((report / "index.html").read_text(encoding="utf-8"))
    return [(html.unescape(href), words(inner)) for href, inner in links if re.search(r"\d", words(inner))]


def trial_behind(report: Path, href: str) -> tuple[Path, str]:
    """Page and row of the trial that an address leads to, by one more click where it leads to a table first."""
    page, _, fragment = href.partition("#")
    if fragment.startswith("trial-"):
        return report / page, fragment
    text = (report / page).read_text(encoding="utf-8")
    section = text[text.index(f'id="{fragment}"') :] if fragment else text
    (further, row) = re.findall(r'href="(case-[^"#]+\.html)#(trial-[^"]+)"', section)[0]
    return report / further, row


def command_of(page: Path, row: str) -> list[str]:
    """The command that a trial's row shows, as words."""
    text = page.read_text(encoding="utf-8")
    rest = text[text.index(f'<tr id="{row}"') :]
    shown = re.search(r'<dt>again</dt><dd><code class="command">(.*?)</code>', rest)
    assert shown is not None
    return shlex.split(html.unescape(shown[1]))[1:]


@pytest.fixture(scope="module")
def run(printed: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("traced")
    (folder / "study.toml").write_text(
        STUDY.format(cases='["flight_projectile", "joint_pendulum"]', engines='["mujoco", "bullet"]', timing="false")
    )
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        done = printed("run", str(folder / "study.toml"), "--out", str(folder / "run"), "--workers", "1")
    assert done.returncode == 0, done.stderr
    return folder / "run"


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Trials are run again in this process."""

    def answers(trials: Sequence[Trial], folder: Path, _workers: int) -> Iterator[Record]:
        for trial in trials:
            yield run_trial(trial, plugins.case(trial.case), plugins.adapter(trial.engine), folder)

    monkeypatch.setattr(isolated, "run_isolated", answers)


def traced(run: Path, printed: Command, count: int) -> set[str]:
    """Ten numbers or all of them; the trials behind them."""
    report, store = run / "report", Store(run)
    known = numbers(report)
    assert len(known) > 10
    met: set[str] = set()
    by_trial = store.trials.set_index("trial")
    for href, text in random.Random(24).sample(known, min(count, len(known))):
        page, row = trial_behind(report, href)
        command = command_of(page, row)
        trial = command[-1]
        assert row == f"trial-{trial}"
        if "real time" in text:
            assert f"{amount(1 / by_trial['cpu_per_sim_s'][trial])}{TIMES}" in text
        elif TIMES in text and trial in margins(store):
            assert margin_words(margins(store)[trial]) in text
        if trial not in met:
            assert printed(*command).stdout.splitlines()[-1] == "bit-identical"
        met.add(trial)
    return met


@BULLET
@pytest.mark.usefixtures("here")
def test_ten_numbers_of_the_first_page_lead_in_two_clicks_to_a_trial_that_runs_again(run: Path, printed: Command) -> None:
    assert len(traced(run, printed, 10)) > 4


@pytest.mark.slow
def test_numbers_of_every_kind_lead_to_trials_that_run_again_in_processes_of_their_own(
    printed: Command, tmp_path: Path
) -> None:
    cases = ["flight_projectile", "joint_pendulum", "friction_isotropy", "impact_bounce", "stack_tower", "joint_chain"]
    (tmp_path / "study.toml").write_text(
        STUDY.format(cases=json.dumps(cases), engines='["mujoco", "bullet", "dart"]', timing="true")
    )
    done = printed("run", str(tmp_path / "study.toml"), "--out", str(tmp_path / "run"), "--workers", "2")
    assert done.returncode == 0, done.stderr
    texts = [text for _, text in numbers(tmp_path / "run" / "report")]
    assert any("real time" in text for text in texts)
    assert any(" draws" in text for text in texts)
    assert len(traced(tmp_path / "run", printed, 40)) > 10
