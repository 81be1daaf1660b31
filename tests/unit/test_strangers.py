"""What a third party's plug-in that cannot be loaded is told."""

import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from plumbline.harness.intake.strangers import trouble

ROOT = str(Path(__file__).parents[2])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("from harness.adapter import Adapter\n", "No module named 'harness'; import plumbline.harness instead"),
        ("import cases.flight_box\n", "No module named 'cases'; import plumbline.cases instead"),
        ("import harnessed\n", "No module named 'harnessed'"),
    ],
)
def test_a_plugin_that_imports_an_old_name_is_told_the_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, reason: str
) -> None:
    (tmp_path / "old_names.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *(folder for folder in sys.path if folder not in ("", ROOT))])
    told = trouble(EntryPoint("old", f"old_names:{len(text)}", "plumbline.adapters"))
    assert told.endswith(reason), told
