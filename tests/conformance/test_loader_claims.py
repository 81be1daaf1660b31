"""No change that an engine's loader makes is published without a script in the vendor's own words, nor shown untold."""

import ast
import tomllib
from pathlib import Path
from typing import Literal

import pytest
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.run.importer_audit import audit
from plumbline.harness.scene.parity.comparison import TOLERANCE
from plumbline.harness.scene.values import FROZEN
from tests.planted_robots import MJCF, URDF

VENDOR = Path(__file__).parents[1] / "vendor"


@dataclass(frozen=True, kw_only=True, config=FROZEN)
class LoaderClaim:
    """What a loader does to files of a format. Terms: as in claims.toml."""

    engine: str
    loader: str
    format: Literal["urdf", "mjcf"]
    kinds: tuple[str, ...] = Field(min_length=1)
    standing: Literal["default", "trap", "undocumented"]
    script: str
    because: str = Field(min_length=1)


CLAIMS = [LoaderClaim(**row) for row in tomllib.loads((VENDOR / "claims.toml").read_text())["loaders"]]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda one: f"{one.engine} {one.loader} {one.format} {one.kinds[0]}")
def test_the_script_of_a_claim_is_there_and_of_its_engine(claim: LoaderClaim) -> None:
    file, _, name = claim.script.partition("::")
    assert file.startswith(f"test_{claim.engine}_")
    assert name in {node.name for node in ast.parse((VENDOR / file).read_text()).body if isinstance(node, ast.FunctionDef)}


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "text"), [("urdf", URDF), ("mjcf", MJCF)])
def test_what_loaders_change_in_a_file_with_all_of_it_is_what_is_claimed(kind: str, text: str, tmp_path: Path) -> None:
    for module in ("mujoco", "dartpy", "pybullet"):
        pytest.importorskip(module)
    path = tmp_path / f"planted.{'urdf' if kind == 'urdf' else 'xml'}"
    path.write_text(text)
    found = {
        (r.engine, r.way, row.kind, bool(row.documented))
        for r in audit(path, Wishes(), TOLERANCE)
        for row in r.rows
        if row.kind
    }
    claimed = {(one.engine, one.loader, word) for one in CLAIMS if one.format == kind for word in one.kinds}
    assert {change[:3] for change in found} == claimed
    told = {(one.engine, one.loader, word) for one in CLAIMS if one.standing == "default" for word in one.kinds}
    assert {change[:3] for change in found if change[3]} <= told
