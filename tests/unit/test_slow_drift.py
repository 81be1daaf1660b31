"""Which nights the look at all nights reads."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from plumbline.harness.history import regressions
from plumbline.harness.store.journal import DamagedFile


def test_the_latest_nights_of_a_season_are_read_from_the_last_one_backwards(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a hundred nights, each of which is damaged: then there is nothing to compare, and nothing more is asked."""
    read: list[Any] = []

    def said_by(_history: Any, night: Any, _store: Any) -> Any:
        read.append(night.stamp)
        if night.stamp < 100:
            raise DamagedFile(Path("night"), "planted", "none")
        return {}

    monkeypatch.setattr(regressions, "said_by", said_by)
    nights: Any = [SimpleNamespace(stamp=stamp, store=lambda: None) for stamp in range(101)]
    anything: Any = None
    assert regressions.over_nights(anything, nights[:100], nights[100], anything, {}, (), 1e9) == ()
    assert read == [100, *range(99, 99 - regressions.MOST, -1)]
