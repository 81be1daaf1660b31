"""The Python interface, as a user's script has it: runs, comparisons, tables, rankings, scenes, and what wrong input raises."""

import ast
import enum
import inspect
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plumbline
from plumbline.harness.findings import tables
from plumbline.harness.scene.file import parse
from plumbline.harness.store.stored_tables import COLUMNS
from plumbline.harness.study import plugins
from tests.run_folder import write_run_folder

ROOT = Path(__file__).parents[2]


def thrown() -> plumbline.Scene:
    """A ball that flies."""
    return plumbline.Scene(bodies=[plumbline.Body(name="ball", p_WB=(0.0, 0.0, 1.0), v_WB=(3.0, 0.0, 8.0))])


def crate() -> plumbline.Scene:
    """A crate on the ground, on a hinge, with a range finder."""
    half = (0.1, 0.1, 0.1)
    box = plumbline.PlacedShape(shape=plumbline.Box(half_extents=half))
    ground = plumbline.PlacedShape(shape=plumbline.Plane())
    return plumbline.Scene(
        bodies=(
            plumbline.Body(name="ground", motion="static", material="floor", collision=(ground,)),
            plumbline.Body(
                name="crate", inertia=plumbline.box_inertia(1.0, half), collision=(box,), material="wood", p_WB=(0.0, 0.0, 0.1)
            ),
            plumbline.Body(name="door", p_WB=(3.0, 0.0, 1.0)),
        ),
        joints=(
            plumbline.Revolute(
                name="hinge",
                parent=plumbline.WORLD,
                child="door",
                anchor_W=(3.0, 0.0, 2.0),
                axis_W=(0.0, 0.0, 1.0),
                limits=plumbline.Limits(lower=-1.0, upper=1.0),
            ),
        ),
        surfaces=(plumbline.Surface.rough(0.5, between=("floor", "wood")),),
        sensors=(plumbline.Lidar(name="finder", body="crate", rate=24.0),),
    )


def python(code: str, folder: Path, **variables: str) -> "subprocess.CompletedProcess[str]":
    """A script in a file, as a user starts it."""
    (folder / "script.py").write_text(code, encoding="utf-8")
    command = [sys.executable, "script.py"]
    return subprocess.run(command, cwd=folder, env=os.environ | variables, capture_output=True, text=True, check=False)


def test_importing_loads_nothing_and_every_public_name_is_there(tmp_path: Path) -> None:
    heavy = ("numpy", "pandas", "pydantic", "click", "pyarrow", "numba")
    code = f"import sys, plumbline; print([n for n in {heavy} if n in sys.modules], len(dir(plumbline)))"
    done = python(code, tmp_path)
    assert done.stdout.startswith("[] "), done.stdout + done.stderr
    assert [name for name in plumbline.__all__ if getattr(plumbline, name, None) is None] == []
    assert len(set(plumbline.__all__)) == len(plumbline.__all__)
    with pytest.raises(AttributeError, match="no attribute 'rnu'"):
        plumbline.rnu  # noqa: B018


def test_type_checkers_see_every_public_name() -> None:
    tree = ast.parse((ROOT / "src" / "plumbline" / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {alias.asname or alias.name for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    from plumbline.harness import scene

    assert set(plumbline.__all__) <= imported | set(scene.__all__)
    assert (ROOT / "src" / "plumbline" / "py.typed").is_file()


def test_help_says_what_each_function_takes_gives_and_raises(tmp_path: Path) -> None:
    text = python("import plumbline; help(plumbline)", tmp_path, PAGER="cat").stdout
    text = re.sub(r"\(\s+", "(", text)  # from Python 3.13 on a long signature has a line for each argument
    for words in ("run(what", "compare(what", "select(results", "Raises: PlumblineError", "(steps + 1, bodies, 3) [m]"):
        assert words in text, words


def test_a_run_keeps_every_step_and_follows_the_law_of_free_fall() -> None:
    """z = z0 + v t - g t^2 / 2; semi-implicit Euler lags by g t dt / 2, 9.81 x 0.5 x (1/240) / 2 = 0.0102 m at the end."""
    run = plumbline.run(thrown(), duration=0.5)
    assert run.status == "finite"
    assert run.bodies == ("ball",)
    assert run.positions.shape == (121, 1, 3)
    assert run.orientations.shape == (121, 1, 4)
    exact = 1.0 + 8.0 * run.time - 9.81 * run.time**2 / 2
    assert np.abs(run.positions[:, 0, 2] - exact).max() <= 9.81 * 0.5 / 240 / 2 + 1e-12
    frame = run.frame()
    assert list(frame["x"]) == list(run.positions[:, 0, 0])
    assert frame.attrs["units"]["vx"] == "m/s"
    assert set(frame.columns) == set(frame.attrs["units"]) == set(frame.attrs["columns"])


def test_a_run_of_a_case_is_judged_and_takes_its_parameters() -> None:
    run = plumbline.run("flight_projectile", "dart", parameters={"mass": 2.0})
    assert run.status == "passed"
    assert run.scene.bodies[0].mass == 2.0
    measured = run.measurements.set_index("metric")
    assert measured.loc["position_error_max", "value"] <= measured.loc["position_error_max", "at_most"]


def test_a_run_here_and_one_in_a_process_of_its_own_give_the_same_bits() -> None:
    apart, here = (plumbline.run(crate(), "mujoco", 0.25, isolated=isolated) for isolated in (True, False))
    assert np.array_equal(apart.positions, here.positions)
    assert apart.signals.keys() == here.signals.keys() >= {"finder/range", "finder/time"}


def test_a_robot_file_says_what_became_of_its_elements(tmp_path: Path) -> None:
    run = plumbline.run(ROOT / "examples" / "arm.urdf", duration=0.1)
    assert set(run.fidelity["outcome"]) <= {"exact", "approximated", "left_out", "dropped"}
    assert run.recording().stat().st_size > 0


def test_numbers_of_numpy_are_numbers() -> None:
    run = plumbline.run(
        "flight_projectile", dt=np.float64(1 / 240), parameters={"mass": np.float32(2.0)}, deadline=np.int64(60)
    )
    assert (run.status, run.scene.bodies[0].mass) == ("passed", 2.0)


CRASHES = """
import plumbline
for engine in ("dies", "hangs"):
    run = plumbline.run(plumbline.Scene(bodies=[plumbline.Body(name="b")]), engine, 0.1, deadline=1.0)
    print(run.status, "|", run.reason)
    try:
        run.positions
    except plumbline.PlumblineError as error:
        print(error)
scene = plumbline.Scene(bodies=[plumbline.Body(name="b")])
print(plumbline.run(scene, "raises", 0.1).reason)
try:
    plumbline.run(scene, "raises", 0.1, isolated=False)
except RuntimeError as error:
    print("here:", error)
"""


def test_an_engine_that_crashes_or_hangs_is_an_outcome_with_its_reason(tmp_path: Path) -> None:
    """In a script without `if __name__ == "__main__"`, which a new process must not run again."""
    (tmp_path / "wild.py").write_text(
        """
import os
from dataclasses import dataclass, field
from plumbline.harness.adapter import Adapter, Feature, Settings

@dataclass(frozen=True, kw_only=True)
class Wild(Adapter):
    distribution: str = "numpy"
    features: Feature = Feature.FULL_INERTIA
    tracks: dict = field(default_factory=lambda: {"default": Settings(), "tuned": Settings()})

    def version(self):
        return "1"

    def build(self, scene, settings):
        if self.name == "dies":
            os.abort()
        if self.name == "raises":
            raise RuntimeError("no luck")
        while True:
            pass

DIES, HANGS, RAISES = (Wild(name=name, title=name) for name in ("dies", "hangs", "raises"))
""",
        encoding="utf-8",
    )
    info = tmp_path / "wild-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: wild\nVersion: 1\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(
        "[plumbline.adapters]\ndies = wild:DIES\nhangs = wild:HANGS\nraises = wild:RAISES\n", encoding="utf-8"
    )
    done = python(CRASHES, tmp_path, PYTHONPATH=str(tmp_path))
    assert done.returncode == 0, done.stderr
    died, none, late, neither, raised, here = done.stdout.splitlines()
    assert died == "crashed | killed by SIGABRT"
    assert none == "dies gave no state: crashed: killed by SIGABRT"
    assert late.startswith("timeout | deadline of 1 s passed")
    assert neither.startswith("hangs gave no state: timeout")
    assert (raised, here) == ("RuntimeError: no luck", "here: no luck")


def test_a_comparison_is_the_run_folder_that_the_command_line_writes(tmp_path: Path) -> None:
    study = plumbline.compare("quick", ["mujoco", "dart"], cases=["flight_projectile"], out=tmp_path / "q", report=False)
    again = plumbline.open(tmp_path / "q")
    assert set(again.trials["engine"]) == {"mujoco", "dart"}
    assert study.trials.equals(again.trials)
    assert set(again.prices["verdict"]) & {"priced", "at most"}
    sentence = plumbline.select(again, need=["flight"]).sentence
    assert "MuJoCo" in sentence or "DART" in sentence


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> plumbline.Results:
    folder = tmp_path_factory.mktemp("run") / "run"
    write_run_folder(folder)
    return plumbline.open(folder)


def test_every_column_of_trials_measurements_samples_and_prices_says_its_unit_and_meaning(results: plumbline.Results) -> None:
    for name in ("trials", "measurements", "samples", "price"):
        frame = results.table(name)
        assert set(frame.columns) == set(frame.attrs["units"]) == set(frame.attrs["columns"]), name
    assert set(results.prices.columns) == set(tables.table("price").columns)
    assert set(results.trials.columns) == set(COLUMNS["trials"])


def test_no_text_is_of_a_column_that_is_not_there() -> None:
    from plumbline.api.frames import _columns

    there = {**COLUMNS, "price": tables.table("price").columns}
    strange = {name: set(about) - set(there[name]) for name, about in _columns().items() if name in there}
    assert strange == {name: set() for name in there}


def test_a_ranking_has_a_row_an_engine_with_its_share_of_resamples(results: plumbline.Results) -> None:
    frame = plumbline.select(results, need=["flight"]).frame()
    placed = frame[frame["left_out"].isna()]
    assert placed["first"].sum() == pytest.approx(1.0)
    assert set(frame.columns) == set(frame.attrs["units"])


def test_a_scene_is_printed_as_the_toml_that_reads_back_to_it() -> None:
    text = plumbline.to_toml(crate())
    assert parse(text, "crate.toml") == crate()
    assert "p_WB = [3.0, 0.0, 1.0]\n" in text
    assert "linear_damping" not in text, "what is as its field has it is not said"
    for name in ("stack_tower", "sensor_lidar_room", "stand_humanoid", "tunnel_thin_mesh"):
        case = plugins.case(name)
        scene = case.scene(case.parameters)
        assert parse(plumbline.to_toml(scene), "case.toml") == scene


def test_load_gives_the_scene_of_a_file_and_of_a_case(tmp_path: Path) -> None:
    (tmp_path / "crate.toml").write_text(plumbline.to_toml(crate()), encoding="utf-8")
    assert plumbline.load(tmp_path / "crate.toml") == crate()
    assert plumbline.load("flight_projectile").bodies
    assert plumbline.load(ROOT / "examples" / "arm.urdf", root="floating").joints


WRONG: tuple[tuple[Callable[[], Any], str], ...] = (
    (lambda: plumbline.run("nowhere.urdf"), r"nowhere\.urdf: there is no such file in /"),
    (lambda: plumbline.run("flight_projectil"), "did you mean flight_projectile"),
    (lambda: plumbline.run("flight_box", "mujoko"), "'mujoko': not found, expected one of .*; did you mean mujoco"),
    (lambda: plumbline.run("flight_box", duration=3.0), "'flight_box': duration 3 s, expected none"),
    (lambda: plumbline.run("flight_box", track="fast"), r"tracks\[0\]: Input should be 'default' or 'tuned', got 'fast'"),
    (lambda: plumbline.run(thrown(), dt=-1.0), r"dt \[s\]: -1, expected 1e-09 to 1"),
    (lambda: plumbline.run(thrown(), duration=1e5, dt=1e-7), "steps"),
    (lambda: plumbline.run(thrown(), root="fixed"), "root: unknown of a scene built in Python"),
    (lambda: plumbline.run("flight_box", parameters={"sped": 1.0}), "'sped': unknown, expected one of speed"),
    (lambda: plumbline.run("flight_box", parameters={"speed": "fast"}), "'speed': 'fast', expected a number"),
    (lambda: plumbline.load(ROOT / "examples" / "arm.urdf", root="bolted"), "root: .*got 'bolted'"),
    (lambda: plumbline.load(ROOT / "examples" / "arm.urdf", convex=1), "convex: 1, expected 2..64"),
    (lambda: plumbline.run(3), r"run: what: 3, expected Scene \| Path \| str"),
    (lambda: plumbline.to_toml(3), "to_toml: 3, expected Scene"),
    (lambda: plumbline.run(thrown(), 5), "run: engine: 5, expected str"),
    (lambda: plumbline.run(thrown(), duration="2"), "run: duration: '2', expected float"),
    (lambda: plumbline.run(thrown(), dt=True), "run: dt: .rue, expected float"),
    (lambda: plumbline.compare(thrown(), "mujoco"), r"compare: engines: 'mujoco', expected Sequence\[str\]"),
    (lambda: plumbline.compare(thrown(), ["mujoco"], workers=0), "workers: 0, expected 1 to 1024"),
    (lambda: plumbline.compare(thrown(), ["mujoco"], budget=-1.0), "budget"),
    (lambda: plumbline.open(5), "open_results: folder: 5"),
    (lambda: plumbline.select("build/q", "friction"), "select: need: 'friction', expected Sequence"),
    (lambda: plumbline.compare("qick"), "did you mean quick"),
    (lambda: plumbline.compare("quick", dt=0.01), "'quick': dt, expected none"),
    (lambda: plumbline.compare("quick", ["mujoco", "mujoco"]), "engine 'mujoco' is given twice"),
    (lambda: plumbline.compare("quick", ["mujoco"], cases=["zz*"]), "case pattern 'zz\\*' names no case"),
    (lambda: plumbline.open("/nowhere"), "/nowhere: no run folder"),
    (lambda: plumbline.Body(name="b", mass=-1.0), "body 'b': mass: .*got -1.0"),
    (lambda: plumbline.Body(name="b", masss=1.0), "did you mean mass"),
)


@pytest.mark.parametrize(("asks", "words"), WRONG)
def test_wrong_input_raises_one_kind_of_error_that_names_the_value(asks: Callable[[], Any], words: str) -> None:
    with pytest.raises(plumbline.PlumblineError, match=words):
        asks()


def test_what_is_refused_is_told_without_the_calls_within(monkeypatch: pytest.MonkeyPatch) -> None:
    """A traceback is the caller's line: the message stands right below. Developers see all of it."""
    with pytest.raises(plumbline.PlumblineError) as refused:
        plumbline.run("nothing.urdf", engine="mujoco")
    assert len(refused.traceback) == 1
    monkeypatch.setattr("plumbline.api.arguments.sys", SimpleNamespace(flags=SimpleNamespace(dev_mode=True)))
    with pytest.raises(plumbline.PlumblineError) as refused:
        plumbline.run("nothing.urdf", engine="mujoco")
    assert len(refused.traceback) > 4


def test_wrong_questions_to_results_raise_it_too(results: plumbline.Results) -> None:
    wrong: tuple[tuple[Callable[[], Any], str], ...] = (
        (lambda: results.table("pric"), "did you mean price"),
        (lambda: plumbline.select(results, need=["cooking"]), "'cooking' is no family or case"),
        (lambda: plumbline.select(results, error=3.0), "error: 3, expected 1e-12 to 1"),
        (lambda: plumbline.select(results, weights={"taste": 1.0}), "weights: 'taste'"),
        (lambda: plumbline.select(results, preset="cooking"), "preset 'cooking'"),
    )
    for asks, words in wrong:
        with pytest.raises(plumbline.PlumblineError, match=words):
            asks()


BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in (ROOT / "README.md", ROOT / "docs" / "python.md")
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL))
]


@pytest.mark.parametrize("block", BLOCKS)
def test_what_the_pages_show_of_python_runs_as_it_stands(block: str, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    done = python(block, tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_the_options_of_robots_are_those_of_the_command_line() -> None:
    from plumbline.api.sources import ImportOptions
    from plumbline.harness.cli.main import main

    options = {parameter.name for parameter in main.commands["scene"].commands["show"].params}
    assert set(ImportOptions.__annotations__) <= options


@pytest.mark.parametrize("name", plumbline.__all__)
def test_help_shows_types_as_people_write_them(name: str) -> None:
    """Without what validates a value, and a noun by its own name."""
    value = getattr(plumbline, name)
    if callable(value) and not (isinstance(value, type) and issubclass(value, Exception | enum.Flag)):
        shown = str(inspect.signature(value))
        assert not re.search(r"Annotated|FieldInfo|Validator|plumbline\.|typing\.", shown), shown
        assert inspect.getdoc(value)
    assert "(*, name: str, " in str(inspect.signature(plumbline.Body))
