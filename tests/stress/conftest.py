"""The ledger of planted faults: each test of this folder may tell of some, and all are printed at the end."""

from collections.abc import Generator
from pathlib import Path

import pytest

from tests.stress.ledger import PROPERTY, Page

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
    """Send what a test told along with its report, which reaches the process that prints."""
    report = yield
    told = "ledger" in getattr(item, "fixturenames", ())
    if told and not report.skipped and (report.failed or report.when == "teardown"):
        failure = str(call.excinfo.value).strip().partition("\n")[0] if call.excinfo else ""
        page = item.stash.setdefault(PAGE, Page())
        test = (Path(item.path).stem.removeprefix("test_"), item.name)
        report.user_properties.append((PROPERTY, [page.faults, test, failure or "failed" * report.failed]))
    return report
