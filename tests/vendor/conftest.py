"""What scripts in a vendor's words are given."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.vendor.bullet_world import World


@pytest.fixture
def world() -> "Iterator[World]":
    """A world of pybullet as it comes, for a test alone."""
    from tests.vendor.bullet_world import World  # late: scripts for other engines need no pybullet

    with World() as made:
        yield made


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes of what explodes into a file where it stands."""
    monkeypatch.chdir(tmp_path)
