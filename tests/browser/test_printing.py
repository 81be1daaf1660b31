"""The report as a PDF that a browser prints."""

import re
from pathlib import Path

import pytest

from plumbline.reports.html.report import write_report
from plumbline.reports.paper.printing import print_report
from tests.browser.conftest import CHROMIUM
from tests.run_folder import write_run_folder


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_all_pages_are_printed_with_an_outline_and_nothing_is_left_behind(tmp_path: Path) -> None:
    folder = write_run_folder(tmp_path / "run", only=("joint_pendulum", "stack_tower"))
    report = write_report(folder).index.parent
    before = {path.name for path in report.iterdir()}
    path = print_report(folder)
    content = path.read_bytes()
    assert content.startswith(b"%PDF-")
    pages = len(re.findall(rb"/Type ?/Page\b", content))
    assert pages >= len(list(report.glob("*.html")))
    assert b"/Outlines" in content
    assert {path.name for path in report.iterdir()} == before | {"report.pdf"}
