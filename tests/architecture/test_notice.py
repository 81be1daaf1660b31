"""NOTICE: whatever of third parties is shipped, or written into a report, stands in it with its licence."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

from plumbline.reports.html.written import vega_bundle

ROOT = Path(__file__).parents[2]
NOTICE = (ROOT / "NOTICE").read_text(encoding="utf-8")
LICENCES = (ROOT / "reports" / "style" / "vega-licences.txt").read_text(encoding="utf-8")
MARKS = {"TEST_OPERATION_FAILED": "fast-json-patch", "Invalid SemVer": "semver"}
"""What stands in the bundle of libraries that are put together before they get there, without a name."""
PICTURES = {path.relative_to(ROOT).as_posix() for path in (ROOT / "docs" / "pictures").glob("*.webp")}
"""Our own: `make screenshots` takes them."""
PUBLISHED = {path.relative_to(ROOT).as_posix() for path in (ROOT / "src" / "plumbline" / "published").glob("*.parquet")}
"""Our own: `plumbline publish` writes them."""
MESHES = {"examples/meshes/forearm.stl"}
"""Our own, too."""


def names_in(text: str) -> set[str]:
    """The words of a text that could be names of packages."""
    return set(re.findall(r"[a-z0-9][a-z0-9.-]*[a-z0-9]", text))


def bundled() -> set[str]:
    """The packages that the program which puts the bundle together carries, of which the bundle is made."""
    import vl_convert

    (program,) = Path(str(vl_convert.__file__)).parent.glob("*.so")
    found = re.findall(rb"/npm/([@a-z0-9._/-]+)@\d+\.\d+\.\d+", program.read_bytes())
    return {name.decode() for name in found} | {name for mark, name in MARKS.items() if mark in vega_bundle()}


def test_every_part_of_the_bundle_is_named_with_its_licence() -> None:
    parts = bundled()
    assert len(parts) >= 60
    assert set(MARKS.values()) < parts
    assert not parts - names_in(NOTICE), "to be added to NOTICE"
    assert not parts - names_in(LICENCES), "to be added to reports/style/vega-licences.txt, with the text of the licence"


@pytest.mark.parametrize("text", ["Redistribution and use", "Permission to use, copy", "Permission is hereby granted"])
def test_the_texts_of_the_licences_and_the_holders_of_copyright_are_there(text: str) -> None:
    assert text in LICENCES
    for holder in (
        "University of Washington Interactive Data Lab",
        "Mike Bostock",
        "Mapbox",
        "Joachim Wester",
        "Isaac Z. Schlueter",
    ):
        assert holder in LICENCES


def test_nothing_of_third_parties_lies_in_the_repository_unnamed() -> None:
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    if not tracked:
        pytest.skip("no repository here")
    binary = {name for name in tracked if (ROOT / name).is_file() and b"\0" in (ROOT / name).read_bytes()[:8192]}
    assert binary == PICTURES | PUBLISHED
    for name in set(tracked) - MESHES:
        assert Path(name).suffix not in {".woff", ".woff2", ".ttf", ".otf", ".obj", ".stl", ".dae", ".wasm"}, name
        if Path(name).suffix in {".css", ".html", ".js", ".svg"}:
            text = (ROOT / name).read_text(encoding="utf-8")
            assert "@font-face" not in text, name
            assert max(map(len, text.splitlines()), default=0) < 5000, f"{name}: a script of others, packed?"


def test_every_dependency_is_named() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for requirement in (*project["dependencies"], *project["optional-dependencies"]["decomposition"]):
        assert re.split(r"[><=;\[ ]", requirement)[0] in names_in(NOTICE), requirement
    assert set(project["license-files"]) == {"LICENSE", "NOTICE"}
