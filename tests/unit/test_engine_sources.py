"""The digest that names the engine's code follows every one of its files."""

from pathlib import Path

import pytest

import engine.compile.sources
from engine.compile.sources import source_digest


def test_another_byte_in_any_file_is_another_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inner = tmp_path / "narrow"
    inner.mkdir()
    for name in ("a.py", "narrow/a.py"):
        (tmp_path / name).write_text("x = 1\n")
    monkeypatch.setattr(engine.compile.sources, "__file__", str(tmp_path / "compile" / "sources.py"))
    first = source_digest()
    assert source_digest() == first
    (inner / "a.py").write_text("x = 2\n")
    second = source_digest()
    (inner / "a.py").rename(inner / "b.py")
    assert len({first, second, source_digest()}) == 3
