"""The ledger of planted faults: each test of this folder may tell of some, and all are printed at the end."""

from collections.abc import Generator
from pathlib import Path

import pytest

from tests.stress.ledger import Ledger, Page

LEDGER = pytest.StashKey[Ledger]()
PAGE = pytest.StashKey[Page]()


@pytest.fixture
def ledger(request: pytest.FixtureRequest) -> Page:
    """Where a test tells of the faults that it planted: `ledger.survived(family, fault, figure)`."""
    page: Page = request.node.stash.setdefault(PAGE, Page())
    return page


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    told = "ledger" in getattr(item, "fixturenames", ())
    if told and not report.skipped and (report.failed or report.when == "teardown"):
        failure = str(call.excinfo.value).strip().partition("\n")[0] if call.excinfo else ""
        page = item.stash.setdefault(PAGE, Page())
        test = (Path(item.path).stem.removeprefix("test_"), item.name)
        item.config.stash.setdefault(LEDGER, Ledger()).close(page.faults, test, failure or "failed" * report.failed)
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    found = config.stash.get(LEDGER, Ledger())
    if len(found):
        terminalreporter.section("planted faults")
        for line in found.lines():
            terminalreporter.line(line)
