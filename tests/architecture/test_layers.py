"""The architecture, checked: who imports whom, what starts lazily, and that every plug-in ends as it should."""

import ast
import importlib
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

from plumbline.harness.study import plugins
from tests.all_metrics import all_metrics

ROOT = Path(__file__).parents[2]
PACKAGES = ("harness", "adapters", "cases", "reports", "engine")
VENDORS = {"mujoco", "pybullet", "dartpy", "numba", "rerun", "altair", "vl_convert", "pyarrow"}


@cache
def texts_of(package: str) -> dict[Path, str]:
    """The text of each file of a package; no tree of it is kept, which each search for garbage would walk."""
    return {path: path.read_text(encoding="utf-8") for path in sorted((ROOT / package).rglob("*.py"))}


def tops(text: str) -> set[str]:
    """The packages that a file imports at its top."""
    tree = ast.parse(text)
    names = [alias.name for node in tree.body if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module or "" for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {name.removeprefix("plumbline.").partition(".")[0] for name in names}


MOVES = ("rename", "replace", "link_to", "move")


def moves(text: str) -> list[str]:
    """The calls of a file that name or move files."""
    if not any(f".{name}(" in text for name in MOVES):
        return []
    return [
        ast.unparse(node)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr in MOVES
        and len(node.args) == (2 if ast.unparse(node.func.value) in ("os", "shutil") else 1)
        and not node.keywords
    ]


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements within one, at any depth; no expressions."""
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        for inside in getattr(node, field, ()):
            yield inside
            yield from statements(inside)


HEAD = re.compile(r"^ *def \w+\((.*?)\)\s*(?:->|:)", re.MULTILINE | re.DOTALL)


def wide(text: str) -> list[str]:
    """The functions of a file that have more than eight parameters, and so eight commas before the end of their heads."""
    if max((head[1].count(",") for head in HEAD.finditer(text)), default=0) < 8:
        return []
    return [
        node.name
        for node in statements(ast.parse(text))
        if isinstance(node, ast.FunctionDef) and len(node.args.posonlyargs + node.args.args + node.args.kwonlyargs) > 8
    ]


def test_every_import_contract_holds() -> None:
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Imports for types alone count too."""
    graph = grimp.build_graph("plumbline", cache_dir=None)
    assert graph.count_imports() > len(graph.modules) > sum(map(len, map(texts_of, PACKAGES))) / 2
    TopologicalSorter({name: graph.find_modules_directly_imported_by(name) for name in graph.modules}).prepare()


def test_the_page_of_the_architecture_names_the_layers_of_the_contract() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (layers,) = (contract["layers"] for contract in contracts if contract["type"] == "layers" and "containers" not in contract)
    page = (ROOT / "docs" / "architecture.md").read_text().partition("| layer |")[2].partition("| `engine` |")[0]
    rows = [line.split("|")[1].strip() for line in page.splitlines()[2:]]
    assert rows == [", ".join(f"`{package}`" for package in layer.replace("plumbline.", "").split(" | ")) for layer in layers]


@pytest.mark.parametrize("package", ["harness", "engine"])
def test_the_listing_of_a_root_is_short(package: str) -> None:
    entries = {path.name for path in (ROOT / package).iterdir()} - {"__pycache__", "__init__.py"}
    assert len(entries) <= 20, sorted(entries)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_long_module_says_in_its_first_line_why_it_is_long(package: str) -> None:
    for path, text in texts_of(package).items():
        lines = text.splitlines()
        assert len(lines) <= 400 or "(over 400 lines: " in lines[0], f"{path} has {len(lines)} lines"


def test_a_function_of_the_engine_has_at_most_eight_parameters() -> None:
    long = [f"{path.relative_to(ROOT)}: {name}" for path, text in texts_of("engine").items() for name in wide(text)]
    assert not long


LOADED = """
import importlib, json, sys
before = set()
for name in sys.argv[1:]:
    importlib.import_module(name)
    after = {module.split(".")[0] for module in sys.modules}
    print(json.dumps(sorted(after - before)))
    before = after
"""


@pytest.fixture(scope="module")
def loaded() -> dict[str, set[str]]:
    """The top-level packages that a fresh interpreter loads with the command line, and then with each adapter."""
    modules = ["plumbline.harness.cli.main", *(f"plumbline.adapters.{name}" for name in plugins.names("adapters"))]
    done = subprocess.run([sys.executable, "-c", LOADED, *modules], capture_output=True, text=True, check=True)
    return dict(zip(modules, map(set, map(json.loads, done.stdout.splitlines())), strict=True))


def test_the_command_line_starts_without_engines_and_without_number_crunchers(loaded: dict[str, set[str]]) -> None:
    assert not loaded["plumbline.harness.cli.main"] & (VENDORS | {"numpy", "scipy", "pandas", "pydantic"})


@pytest.mark.parametrize("name", plugins.names("adapters"))
def test_an_adapter_is_imported_without_its_vendor(name: str, loaded: dict[str, set[str]]) -> None:
    assert not loaded[f"plumbline.adapters.{name}"] & {"mujoco", "pybullet", "dartpy", "numba"}


NAMED = re.compile(rf"^(?:import|from)\b.*\b(?:{'|'.join(VENDORS)})\b", re.MULTILINE)
"""A line that may import a vendor's package at the top of a file."""


@pytest.mark.parametrize("package", PACKAGES)
def test_vendor_packages_are_imported_inside_functions_only(package: str) -> None:
    allowed = {"engine": {"numba"}}.get(package, set())
    for path, text in texts_of(package).items():
        if NAMED.search(text):
            found = tops(text) & VENDORS
            assert found <= allowed, f"{path.relative_to(ROOT)} imports {found} at its top"


VENDOR_SCRIPTS = sorted((ROOT / "tests" / "vendor").glob("*.py"))


@pytest.mark.parametrize("path", VENDOR_SCRIPTS, ids=lambda path: path.stem)
def test_a_script_in_the_vendor_s_words_uses_nothing_of_ours(path: Path) -> None:
    nodes = list(ast.walk(ast.parse(path.read_text())))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    ours = [name for name in names if name.split(".")[0] in PACKAGES or (name.startswith("tests.") and ".vendor" not in name)]
    assert not ours
    if path.stem.startswith("test_"):
        engine = path.stem.split("_")[1]
        assert engine in ("bullet", "dart", "mujoco", "newton", "rapier", "sapien")
        assert f"pytestmark = pytest.mark.{engine}\n" in path.read_text(), "the mark that it is chosen by"


@pytest.mark.parametrize("kind", ["adapters", "cases"])
def test_every_plug_in_is_found_and_ends_in_its_constant(kind: str) -> None:
    found = {"adapters": plugins.adapters, "cases": plugins.cases}[kind]()
    files = {path.stem: path for path in (ROOT / kind).glob("*.py") if path.stem != "__init__"}
    files |= {path.parent.name: path for path in (ROOT / kind).glob("*/__init__.py")}
    assert files.keys() <= found.keys()
    constant = {"adapters": "ADAPTER", "cases": "CASE"}[kind]
    for path in files.values():
        last = ast.parse(path.read_text()).body[-1]
        targets = last.targets if isinstance(last, ast.Assign) else [last.target] if isinstance(last, ast.AnnAssign) else []
        assert [t.id for t in targets if isinstance(t, ast.Name)] == [constant]


def test_metrics_have_unique_names_units_and_sources() -> None:
    for name, metric in all_metrics().items():
        assert name == metric.name
        assert metric.unit
        assert metric.source


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_exists(package: str) -> None:
    for path in texts_of(package):
        parts = ("plumbline", *path.relative_to(ROOT).with_suffix("").parts)
        module = importlib.import_module(".".join(parts).removesuffix(".__init__"))
        for name in getattr(module, "__all__", ()):
            assert hasattr(module, name), f"{module.__name__}.__all__ names {name}, which is not there"


def test_every_dependency_is_locked_and_no_index_is_named() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lock = (ROOT / "requirements.lock").read_text()
    assert "://" not in lock
    assert "index" not in lock
    for requirement in (*project["dependencies"], *project["optional-dependencies"]["dev"]):
        name = requirement.split(">")[0].split("=")[0].split(";")[0].strip()
        assert f"\n{name}==" in f"\n{lock}", f"{name} is not in requirements.lock"


def test_files_get_their_names_in_one_function() -> None:
    """It synchronises the file before and the folder behind. A report that makes way is thrown away, and convex pieces that
    are kept can be worked out again."""
    found = [
        f"{path.relative_to(ROOT)}: {move}"
        for package in ("harness", "reports")
        for path, text in texts_of(package).items()
        for move in moves(text)
    ]
    assert found == [
        "harness/intake/user_cache.py: draft.replace(path)",
        "harness/store/disk.py: old.replace(new)",
        "reports/html/report.py: report.rename(old)",
    ]
