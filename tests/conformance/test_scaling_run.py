"""A small scaling study, run for real through the command line: its table in every format, and its page."""

import csv
import io
import json
from pathlib import Path

import pytest

from plumbline.harness.findings.tables.scaling import TABLE
from plumbline.harness.study import plugins
from tests.conftest import Command

STUDY = """
name = "small"
recordings = false
[variants.mujoco]
cg = {{ on = "default", solver = "cg" }}
[[experiments]]
name = "pile"
cases = ["stack_pile"]
tracks = ["default"]
variants = ["*"]
parameters = {{ n = [4, 6, 8] }}
samples = 2
sample_seconds = 0.002
deadline = {deadline}
[[experiments]]
name = "worlds"
cases = ["stack_pile"]
tracks = ["default"]
parameters = {{ n = [4], worlds = [3] }}
samples = 2
sample_seconds = 0.002
deadline = {deadline}
[[experiments]]
name = "rays"
cases = ["system_rays"]
tracks = ["tuned"]
parameters = {{ thin = [64, 128, 256] }}
samples = 2
sample_seconds = 0.002
deadline = {deadline}
[[experiments]]
name = "overhead"
cases = ["flight_box"]
tracks = ["default"]
clocks = ["work", "reading", "call"]
samples = 2
sample_seconds = 0.002
deadline = {deadline}
[[experiments]]
name = "side-by-side"
cases = ["stack_pile"]
tracks = ["default"]
parameters = {{ n = [4] }}
workers = [1, 3]
samples = 2
sample_seconds = 0.002
deadline = {deadline}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, printed: Command) -> Path:
    version, reason = plugins.version_of(plugins.adapter("mujoco"))
    if reason is not None:
        pytest.skip(f"MuJoCo {version}: {reason}")
    out = tmp_path_factory.mktemp("scaling")
    (out / "small.toml").write_text(STUDY.format(deadline=200.0))
    done = printed("run", out / "small.toml", "--engine", "mujoco", "--out", out / "run")
    assert done.returncode == 0, done.stderr
    return out / "run"


def test_every_scene_and_setting_has_a_price_for_its_own_unit(folder: Path, printed: Command) -> None:
    rows = json.loads(printed("show", folder, "--table", "scaling", "--format", "json").stdout)
    assert all(tuple(row) == TABLE.columns for row in rows)
    costs = [row for row in rows if row["row"] == "cost"]
    assert {(row["where"], row["track"], row["unit"]) for row in costs} == {
        *((f"{n} balls", track, "step") for n in (4, 6, 8) for track in ("default", "cg")),
        ("4 balls, 3 worlds", "default", "world-step"),
        *((f"one ray in {thin}", "tuned", "ray") for thin in (64, 128, 256)),
        ("step alone", "default", "step"),
        ("step and reading", "default", "read-step"),
        ("empty call", "default", "call"),
        *((f"4 balls, {workers}", "default", "step") for workers in ("1 process", "3 processes")),
    }
    for row in costs:
        assert 0 < row["cpu_low_s"] <= row["cpu_s"] <= row["cpu_high_s"]
    assert sum(row["best"] for row in costs) == 7  # one a scene, none beside the work
    assert {(row["track"], row["unit"]) for row in rows if row["row"] == "exponent"} == {
        ("default", "step"), ("cg", "step"), ("tuned", "cast"),
    }  # fmt: skip
    compared = {row["where"]: row for row in costs if row["to_plain"] is not None}
    assert compared.keys() == {"step and reading", "empty call"}
    assert all(0 < row["to_plain_low"] <= row["to_plain"] <= row["to_plain_high"] for row in compared.values())
    shared = {row["workers"]: row for row in costs if row["efficiency"] is not None}
    assert shared.keys() == {1, 3}
    assert shared[1]["efficiency"] == 1.0
    assert 0 < shared[3]["efficiency_low"] <= shared[3]["efficiency"] <= shared[3]["efficiency_high"]
    assert all(row["rate_per_s"] > 0 for row in shared.values())


def test_the_table_is_printed_in_every_format(folder: Path, printed: Command) -> None:
    sheet = list(csv.DictReader(io.StringIO(printed("show", folder, "--table", "scaling", "--format", "csv").stdout)))
    assert len(sheet) == 18
    markdown = printed("show", folder, "--table", "scaling", "--format", "markdown").stdout
    assert len(markdown.splitlines()) == 2 + len(sheet)
    text = printed("show", folder, "--table", "scaling").stdout
    assert "stack_pile 8 balls" in text
    assert "exponent" in text


def test_the_report_has_the_page_with_its_charts_and_sheet(folder: Path) -> None:
    report = folder / "report"
    page = (report / "scaling.html").read_text()
    assert 'href="scaling.html" aria-current="page"' in page
    for name in ("growth-0", "standings"):
        assert f'id="{name}"' in page
        assert (report / "charts" / f"{name}.svg").is_file()
    assert len((report / "scaling.csv").read_text().splitlines()) == 19
    for section in ("beside", "shared"):
        assert f'id="{section}"' in page
