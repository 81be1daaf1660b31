"""The page on scaling: there where a parameter was swept under the clock, absent elsewhere, and safe with hostile names."""

import json
from pathlib import Path

import pytest

from harness.store import Store
from reports.html import rendered
from tests.run_folder import write_run_folder
from tests.unit.test_scaling import Scaling, at, scaling  # noqa: F401 -- the fixture


def test_a_store_without_a_sweep_has_no_such_page_and_no_link_to_it(tmp_path: Path) -> None:
    texts = rendered(Store(write_run_folder(tmp_path / "run", only=("stack_tower",))))
    assert "scaling.html" not in texts
    assert "scaling.html" not in texts["index.html"]


def test_a_store_with_a_sweep_has_the_page_with_every_row(scaling: Scaling) -> None:  # noqa: F811
    texts = rendered(scaling._store)
    page = texts["scaling.html"]
    assert 'href="scaling.html"' in texts["index.html"]
    assert page.count("data-status=") == len(scaling.costs)
    assert "it took too long" in page
    assert "1.25" in texts["charts/growth-0.svg"]
    assert len(texts["scaling.csv"].splitlines()) == 1 + len(scaling.rows())


def test_a_hostile_name_stays_text(scaling: Scaling, monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: F811
    attack = "<script>window.attacked=1</script>"
    catalogue = json.loads(json.dumps(scaling._store.catalogue))
    catalogue["cases"]["stack_pile"]["title"] = attack
    monkeypatch.setattr(type(scaling._store), "catalogue", catalogue)
    texts = rendered(Store(scaling._store.folder))
    assert attack not in texts["scaling.html"]
    assert at(scaling, 10, "ours", "fine").cpu is not None
