"""Which texts decide an answer: found by their imports, changed by their content."""

import ast
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from plumbline.harness.study import plugins, provenance, sources

ROOT = Path(sources.__file__).parents[2]


def clear() -> None:
    for module in (sources, provenance):
        for one in vars(module).values():
            if hasattr(one, "cache_clear"):
                one.cache_clear()


@pytest.fixture(autouse=True)
def _fresh() -> Iterator[None]:
    clear()
    yield
    clear()


def statements(node: ast.AST) -> Iterator[ast.stmt]:
    """Those of a node and of all within it: what is no statement holds none."""
    for part in ast.iter_child_nodes(node):
        if isinstance(part, ast.stmt | ast.excepthandler | ast.match_case):
            if isinstance(part, ast.stmt):
                yield part
            yield from statements(part)


def by_the_parser(module: str, path: Path) -> set[str]:
    """Every name that a file's import statements may lead to."""
    found = set()
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    for node in statements(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = [*(package[: len(package) - node.level + 1] if node.level else ()), *(node.module or "").split(".")]
            base = [part for part in base if part]
            found |= {".".join((*base, alias.name)) for alias in node.names} | {".".join(base)}
    return found


@pytest.mark.parametrize(
    ("tops", "least"), [(("adapters",), 300), pytest.param(("cases", "engine", "harness"), 1000, marks=pytest.mark.slow)]
)
def test_the_quick_scan_finds_every_import_that_the_parser_finds(tops: tuple[str, ...], least: int) -> None:
    seen = 0
    for top in tops:
        for path in (ROOT / top).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            module = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            ours = {name for name in by_the_parser(module, path) if name.partition(".")[0] in sources._OURS}
            due = {name for name in ours if sources._file(name) and not sources.keeps(name)}
            assert due <= sources.imported(module), module
            seen += len(due)
    assert seen > least


def test_a_case_rests_on_what_it_imports_and_on_nothing_else() -> None:
    modules = sources.closure(["plumbline.cases.impact_bounce"])
    assert {
        "plumbline.cases.impact_bounce",
        "plumbline.harness.metrics.impacts",
        "plumbline.harness.case.bounds",
        "plumbline.harness.scene.scene",
    } <= modules
    assert (
        not {
            "plumbline.cases.impact_cradle",
            "plumbline.harness.store.journal",
            "plumbline.harness.metrics.stack",
            "plumbline.engine",
        }
        & modules
    )


def test_our_adapter_rests_on_the_whole_engine_and_another_on_none_of_it() -> None:
    files = {path.relative_to(ROOT).as_posix() for path in (ROOT / "engine").rglob("*.py")}
    assert files <= set(sources.file_digests(sources.closure(["plumbline.adapters.reference"])))
    assert not any(module.startswith("plumbline.engine") for module in sources.closure(["plumbline.adapters.mujoco"]))


def test_what_finds_and_keeps_is_not_among_what_answers() -> None:
    answering = provenance._harness() | provenance._stepping()
    assert {
        "plumbline.harness.trial.accuracy",
        "plumbline.harness.trial.simulate",
        "plumbline.harness.case.alteration",
        "plumbline.harness.trial.truth_cache",
    } <= answering
    assert not any(map(sources.keeps, answering))


@pytest.mark.parametrize(
    ("file", "part"),
    [
        ("cases/impact_bounce.py", "case"),
        ("harness/metrics/impacts.py", "case"),
        ("adapters/mujoco/flags.py", "adapter"),
        ("harness/trial/simulate.py", "stepping"),
        ("harness/sensors/recorder.py", "stepping"),
        ("harness/trial/truth_cache.py", "harness"),
    ],
)
def test_a_changed_file_changes_its_part_and_is_named(file: str, part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    was, files = provenance.sources_of("impact_bounce", "mujoco"), provenance.files_of(["impact_bounce"], ["mujoco"])
    assert provenance.what_changed("impact_bounce", "mujoco", was, files) == ""
    clear()
    plain = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda self: plain(self) + b"\n# changed" * (self == ROOT / file))
    now = provenance.sources_of("impact_bounce", "mujoco")
    assert {name for name in now if now[name] != was[name]} == {part}
    assert provenance.what_changed("impact_bounce", "mujoco", was, files).endswith(f"changed: {file}")


def test_a_truth_that_our_engine_makes_rests_on_it(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "truth" not in provenance.sources_of("impact_bounce", "mujoco")
    assert "engine/world.py" not in provenance.files_of(["impact_bounce"], ["mujoco"])
    clear()
    made = replace(plugins.case("impact_bounce"), expected=None, coarsest=0.01)
    monkeypatch.setattr(plugins, "case", {"impact_bounce": made}.__getitem__)
    assert "truth" in provenance.sources_of("impact_bounce", "mujoco")
    assert "engine/world.py" in provenance.files_of(["impact_bounce"], ["mujoco"])


def test_a_third_partys_package_is_followed_within_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "strange"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "engine.py").write_text("from . import parts\nfrom .more import (\n    thing,\n)\nimport numpy\n")
    (package / "parts.py").write_text('"""\nfrom here on prose\n"""\nfrom plumbline.harness.scene import Scene\n')
    (package / "more.py").write_text("thing = 1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    modules = sources.closure(["strange.engine"])
    assert {"strange", "strange.engine", "strange.parts", "strange.more", "plumbline.harness.scene.scene"} <= modules
    before = sources.digest_of(modules)
    (package / "more.py").write_text("thing = 2\n")
    clear()
    assert sources.digest_of(sources.closure(["strange.engine"])) != before


def test_a_scene_file_of_ones_own_is_part_of_its_case(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text("first")
    before = provenance.sources_of(f"{plugins.SCENE_PREFIX}{path}", "mujoco")
    path.write_text("second")
    clear()
    after = provenance.sources_of(f"{plugins.SCENE_PREFIX}{path}", "mujoco")
    assert {name for name in after if after[name] != before[name]} == {"case"}
