"""The script of the charts is made once, and what was kept is believed only where it is what was made."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from plumbline.reports.html import written


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """How often the script was made, with a cache of its own."""
    calls: list[str] = []
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda _name: str(tmp_path / "cache"))

    def make() -> str:
        calls.append("made")
        return "chart();\r\n"

    monkeypatch.setattr(written, "_made", make)
    yield calls
    written.vega_bundle.cache_clear()


def bundle() -> str:
    written.vega_bundle.cache_clear()
    return written.vega_bundle()


def test_it_is_made_once_and_kept(made: list[str], tmp_path: Path) -> None:
    assert bundle() == bundle() == "chart();\r\n"
    assert made == ["made"]
    (kept,) = (tmp_path / "cache" / "vega").iterdir()
    assert kept.read_bytes().endswith(b"chart();\r\n")


@pytest.mark.parametrize("content", [b"", b"steal();", b"\xff\xfe"])
def test_a_kept_one_that_was_changed_is_made_anew(made: list[str], tmp_path: Path, content: bytes) -> None:
    bundle()
    (kept,) = (tmp_path / "cache" / "vega").iterdir()
    kept.write_bytes(content)
    assert bundle() == "chart();\r\n"
    assert made == ["made", "made"]
    assert bundle() == "chart();\r\n"
    assert len(made) == 2


def test_where_nothing_can_be_kept_it_is_made_each_time(made: list[str], tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("in the way")
    assert bundle() == bundle() == "chart();\r\n"
    assert made == ["made", "made"]
