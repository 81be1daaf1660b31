"""The five recipes of CONTRIBUTING work as they are printed."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from plumbline.harness.intake import strangers
from plumbline.harness.scene.importers import known
from plumbline.harness.store.store import Store
from plumbline.reports.html import report as html
from plumbline.reports.page import pages
from tests.conftest import Command

ROOT = Path(__file__).parents[2]
GROUPS = {
    "adapters/flight.py": ("adapters", "flight", "ADAPTER"),
    "cases/flight_straight.py": ("cases", "flight_straight", "CASE"),
    "harness/metrics/way.py": ("", "way", ""),
    "reports/pages/roll.py": ("pages", "roll", "PAGE"),
    "harness/scene/importers/formats/chain.py": ("importers", "chain", "IMPORTER"),
}


def recipes() -> dict[str, str]:
    blocks = re.findall(r"```python\n# (\S+)\n(.*?)```", (ROOT / "CONTRIBUTING.md").read_text(), flags=re.DOTALL)
    return dict(blocks)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks like an installed package with all five recipes in it."""
    folder = tmp_path_factory.mktemp("recipes")
    info = folder / "recipes-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: recipes\nVersion: 1.0\n")
    package = folder / "recipes"
    package.mkdir()
    (package / "__init__.py").touch()
    lines = []
    for path, text in recipes().items():
        group, name, constant = GROUPS[path]
        (package / f"{name}.py").write_text(text)
        lines += [] if not group else [f"[plumbline.{group}]\n{name} = recipes.{name}:{constant}\n"]
    (info / "entry_points.txt").write_text("".join(lines))
    return folder


@pytest.fixture
def call(installed: Path, printed: Command, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """The command line where the recipes are installed; otherwise a process looks for importers once.

    They are not tried in processes of their own before: one that does not load fails here.
    """
    monkeypatch.syspath_prepend(installed)
    monkeypatch.setattr(strangers, "_tried", lambda *where: ("", strangers.Facts(**strangers.loaded(*where))))
    monkeypatch.setattr(known, "_found", known._found.__wrapped__)

    def called(*arguments: object) -> str:
        done = printed(*arguments)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return called


def test_all_five_recipes_are_printed() -> None:
    assert recipes().keys() == GROUPS.keys()


LISTED = """
import json
from plumbline.harness.study import plugins
from recipes.way import way
found = {kind: plugins.names(kind) for kind in ("adapters", "cases")}
print(json.dumps(found | {"unit": way.unit}))
"""


def test_the_new_engine_the_new_case_and_the_new_metric_are_listed(installed: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(installed)}
    done = subprocess.run([sys.executable, "-c", LISTED], env=environment, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert "flight" in found["adapters"]
    assert "flight_straight" in found["cases"]
    assert found["unit"] == "m"


def test_the_new_engine_answers_the_new_case_and_the_new_page_shows_it(
    call: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The pages beside it are found, and not made."""
    monkeypatch.setattr(html, "pages", lambda: tuple(page for page in pages() if page.name == "roll"))
    study = tmp_path / "one.toml"
    study.write_text('name = "one"\nrecordings = false\n[[experiments]]\nname = "e"\ntiming = false\n')
    call("run", study, "--engine", "flight", "--case", "flight_straight", "--out", tmp_path / "out")
    trials = Store(tmp_path / "out").trials
    assert list(trials["status"]) == ["passed", "passed"]
    assert "<li>flight</li>" in (tmp_path / "out" / "report" / "roll.html").read_text()


@pytest.mark.parametrize("track", ["default", pytest.param("tuned", marks=pytest.mark.slow)])
def test_the_new_engine_keeps_the_contract(call: Callable[..., str], track: str) -> None:
    """Its tracks have the same settings."""
    statuses = {row["status"] for row in json.loads(call("check", "flight", "--track", track, "--json"))}
    assert "passed" in statuses
    assert not statuses & {"failed", "improved"}


def test_the_new_importer_reads_its_format_in_every_command(call: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "two.chain").write_text("upper 1.0 2.0\nlower 0.5 1.0\n")
    rows = json.loads(call("scene", "show", tmp_path / "two.chain", "--root", "fixed", "--json"))
    assert [(row["name"], row["mass"]) for row in rows if row["kind"] == "body"] == [("upper", 2.0), ("lower", 1.0)]
    inertia = '<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{1}"/>'
    links = "".join(
        f'<link name="{name}"><inertial><origin xyz="0 0 {-length / 2}"/><mass value="{mass}"/>'
        f"{inertia.format(mass * length**2 / 12, mass * length**2 / 12e6)}</inertial></link>"
        f'<joint name="{name}_hinge" type="continuous"><parent link="{above}"/><child link="{name}"/>'
        f'<origin xyz="0 0 {at}"/><axis xyz="0 1 0"/></joint>'
        for name, length, mass, above, at in (("upper", 1.0, 2.0, "base", 0.0), ("lower", 0.5, 1.0, "upper", -1.0))
    )
    (tmp_path / "two.urdf").write_text(f'<robot name="two"><link name="base"/>{links}</robot>')
    same = call("parity", tmp_path / "two.chain", tmp_path / "two.urdf", "--tolerance", "1e-9")
    assert "the same robot: 2 joints" in same
