"""A fork server that is killed, busy or idle, costs no cell; an engine that kills its own costs its own cells alone."""

import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from multiprocessing.process import BaseProcess
from pathlib import Path

import pandas as pd
import psutil
import pytest

from plumbline.harness.run.fork_servers import WORTH_A_SERVER, Server, context, start_apart, start_loaded
from plumbline.harness.store.store import Store
from tests.conftest import Command
from tests.light_servers import light_servers
from tests.stress.ledger import Page
from tests.stress.test_interruption import start

HEAD = """
name = "servers"
recordings = false
[[experiments]]
name = "servers"
cases = ["stress_fall"]
tracks = ["tuned"]
dt = [{steps}]
"""
MORE = {
    "plain": "timing = false",
    "loaded": "timing = false",
    "apart": "timing = false\ndeterminism = true",
    "clock": "timing = true\nsamples = 6\nsample_seconds = 0.05",
}
ENGINE = {"plain": "slow", "loaded": "loading", "apart": "slow", "clock": "slow"}
CELLS = {"plain": 6, "loaded": 24, "apart": 3, "clock": 2}
MARK = {
    "plain": "plumbline.harness.cli.main",
    "loaded": "xml.dom.pulldom",
    "apart": "plumbline.harness.cli.main",
    "clock": "plumbline.harness.cli.main",
}


def servers(of: int, mark: str) -> list[psutil.Process]:
    """The fork servers that a process has, by a module that they preload."""
    found = []
    with suppress(psutil.Error):  # what has just ended
        for child in psutil.Process(of).children():
            line = " ".join(child.cmdline())
            if "forkserver import main" in line and mark in line:
                found.append(child)
    return found


def study(folder: Path, kind: str) -> Path:
    path = folder / "servers.toml"
    steps = ", ".join(f"{0.5 / n:.17g}" for n in range(30, 30 + CELLS[kind]))
    path.write_text(HEAD.format(steps=steps) + MORE[kind] + "\n")
    return path


def answers(out: Path) -> pd.DataFrame:
    trials = Store(out).trials
    assert trials["trial"].is_unique
    return trials.set_index("trial").sort_index()


def busy(server: psutil.Process) -> bool:
    try:
        return bool(server.children())
    except psutil.Error:
        return False


SLOW = pytest.mark.slow


@SLOW
@pytest.mark.parametrize("kind", MARK)
def test_a_fork_server_that_is_killed_at_work_costs_no_cell(
    kind: str, tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page
) -> None:
    process = start(study(tmp_path, kind), tmp_path / "out", with_plugins, engine=ENGINE[kind])
    killed, until = 0, time.monotonic() + 200.0
    while process.poll() is None and not killed and time.monotonic() < until:
        for server in servers(process.pid, MARK[kind]):
            if busy(server) and _at_work(tmp_path / "out"):
                server.kill()
                killed += 1
        time.sleep(0.03)
    _, errors = process.communicate(timeout=200)
    assert killed
    assert process.returncode == 0, errors
    found = answers(tmp_path / "out")
    # Repetitions that need a saved state are unsupported: this engine has none.
    assert set(found["status"]) <= {"passed", "unsupported"}
    assert (found["status"] == "passed").sum() >= CELLS[kind]
    if kind == "clock":
        assert found["cpu_per_sim_s"].notna().all()
    ledger.survived("fork servers", f"{kind}, killed at work", f"servers killed {killed}, cells lost 0 of {len(found)}")


def _at_work(out: Path) -> bool:
    journal = out / "journal.jsonl"
    return journal.is_file() and journal.stat().st_size > 0


@SLOW
@pytest.mark.parametrize("timing", ["false", "true"])
def test_an_engine_that_kills_its_fork_server_costs_its_own_cells_alone(
    timing: str, tmp_path: Path, plumbline: Command, ledger: Page
) -> None:
    (tmp_path / "servers.toml").write_text(HEAD.format(steps="0.01, 0.02") + f"timing = {timing}\nsamples = 3\n")
    engines = [word for name in ("sound", "patricide", "slow") for word in ("--engine", name)]
    done = plumbline("run", tmp_path / "servers.toml", *engines, "--out", tmp_path / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    found = answers(tmp_path / "out").set_index("engine")
    assert set(found.loc[["sound", "slow"], "status"]) == {"passed"}
    assert set(found.loc["patricide", "status"]) == {"crashed"}
    assert set(found.loc["patricide", "reason"]) == {"its fork server died with it, alone too"}
    ledger.survived("fork servers", f"killed by an engine, timing {timing}", "other cells lost 0")


def _nothing() -> None:
    pass


STARTS: dict[str, Callable[[BaseProcess], Server]] = {
    "plain": lambda process: start_loaded(process, (), 1),
    "loaded": lambda process: start_loaded(process, ("xml.dom.pulldom",), WORTH_A_SERVER),
    "apart": lambda process: start_apart(process, 7),
    "its own": lambda process: start_apart(process, 7, only="a trial"),
}


@pytest.fixture
def light() -> Iterator[None]:
    with light_servers():
        yield


def begun(kind: str, work: Callable[..., object], *of: object) -> tuple[BaseProcess, Server]:
    process = context().Process(target=work, args=of, daemon=True)
    return process, STARTS[kind](process)


@pytest.mark.parametrize("kind", [kind if kind == "plain" else pytest.param(kind, marks=SLOW) for kind in STARTS])
def test_a_fork_server_that_is_killed_has_a_successor(kind: str, light: None, ledger: Page) -> None:
    """Idle, and with a process whose end nobody can tell then; an exit code of the engine's own is no such end."""
    process, server = begun(kind, os._exit, 255)
    process.join(60.0)
    assert process.exitcode == 255
    assert not server.took_along(process)
    os.kill(server.pid, signal.SIGKILL)
    process, successor = begun(kind, time.sleep, 600)
    assert server.ended
    assert successor.pid != server.pid
    os.kill(successor.pid, signal.SIGKILL)
    process.join(60.0)
    assert successor.took_along(process)
    os.kill(process.pid or 0, signal.SIGKILL)  # what is not confined lives on
    process, last = begun(kind, _nothing)
    process.join(60.0)
    assert process.exitcode == 0
    assert not last.ended
    for when in ("idle", "with a process"):
        ledger.survived("fork servers", f"{kind}, killed {when}", "processes that could not start 0")


@SLOW
def test_the_tracker_of_shared_things_may_die_as_well(tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page) -> None:
    process = start(study(tmp_path, "plain"), tmp_path / "out", with_plugins, engine="slow")
    killed, until = 0, time.monotonic() + 100.0
    while process.poll() is None and not killed and time.monotonic() < until:
        for child in psutil.Process(process.pid).children() if _at_work(tmp_path / "out") else ():
            if "resource_tracker" in " ".join(child.cmdline()):
                os.kill(child.pid, signal.SIGKILL)
                killed += 1
        time.sleep(0.01)
    _, errors = process.communicate(timeout=200)
    assert killed
    assert process.returncode == 0, errors
    assert set(answers(tmp_path / "out")["status"]) == {"passed"}
    ledger.survived("fork servers", "resource tracker killed", f"cells lost 0 of {CELLS['plain']}")
