"""The page on the chapters of a first course: links and cases are there, no concept is missing, no technique is left out."""

import re
import tomllib
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from plumbline.harness.study import plugins

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "book.md").read_text(encoding="utf-8")
HEADER = ("concept", "formula", "file", "case that measures it")
ROOMS = ("integrate", "broad", "narrow", "respond", "swept", "rays")
"""Folders of the engine in which every file is a technique, or what one is made of."""
REQUIRED = (
    "rigid body", "mass and inertia tensor", "force at a point", "explicit Euler", "semi-implicit Euler", "Verlet", "RK4",
    "implicit midpoint", "adaptive Dormand-Prince", "splitting of the free rigid body", "AABB", "OBB", "bounding sphere",
    "uniform grid", "octree", "sweep and prune", "sphere-sphere", "box-box SAT", "capsules", "cylinders",
    "triangles and meshes", "triangle-triangle", "mesh against mesh",
    "GJK", "EPA", "contact manifold", "impulse-based response",
    "constraint-based response by soft TGS", "constraint-based response by the exact solver", "restitution",
    "Coulomb friction", "static and kinetic friction", "rolling friction", "linear damping", "angular damping",
    "joints as constraints", "projection", "SHAKE", "islands", "sleeping", "parallel pairs", "parallel islands",
    "parallel solver", "many worlds", "speculative contact", "swept collision", "event-driven collision", "level of detail",
    "visual against collision geometry", "fixed step", "variable step", "ray casting", "rasterising", "ray tracing",
    "pinhole camera", "lens distortion", "LiDAR", "IMU", "depth camera by structured light", "depth camera by time of flight",
    "depth camera by stereo", "range noise", "dropout", "missing data", "tunnelling", "jitter", "energy drift", "scale",
)  # fmt: skip


def rows(page: str) -> list[list[str]]:
    """The cells of all tables, without their headers."""
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if line.startswith("|")]
    return [row for row in cells if tuple(row) != HEADER and set(row[0]) != {"-"}]


def linked(page: str) -> list[str]:
    """The file of each row, by its path from the root; the cell as it is where its link is not one to what it shows."""
    links = [re.fullmatch(r"\[([\w/]+\.py)\]\(\.\./\1\)", row[2]) for row in rows(page)]
    return [row[2] if link is None else link[1] for row, link in zip(rows(page), links, strict=True)]


def ends_nowhere(page: str) -> list[str]:
    """Links to files that are not there."""
    return [path for path in linked(page) if not (ROOT / path).is_file()]


def unknown_cases(page: str) -> list[str]:
    """What stands for a case and is none of the catalogue; "none" needs a reason."""
    cells = [row[3] for row in rows(page)]
    named = [re.match(r"`(\w+)`(?: with `\w+ = [^`]+`)?$", cell) for cell in cells]
    return [
        cell
        for cell, name in zip(cells, named, strict=True)
        if not re.match(r"none: \S+ \S+ \S+", cell) and (name is None or name[1] not in plugins.names("cases"))
    ]


def asked(page: str) -> list[tuple[str, str, str]]:
    """Case, setting and value of each row that says with what its case takes the technique."""
    found = [re.match(r"`(\w+)` with `(\w+) = ([^`]+)`$", row[3]) for row in rows(page)]
    return [(one[1], one[2], one[3]) for one in found if one]


def not_once(page: str) -> list[str]:
    """Required concepts that are missing, and concepts that stand there twice."""
    told = Counter(row[0] for row in rows(page))
    return [concept for concept in dict.fromkeys((*REQUIRED, *told)) if told[concept] != 1]


@cache
def techniques() -> frozenset[Path]:
    """The files of the rooms."""
    return frozenset(path for room in ROOMS for path in (ROOT / "engine" / room).rglob("*.py") if path.name != "__init__.py")


@cache
def imported(path: Path) -> frozenset[Path]:
    """The files of the engine that one imports, those whose folder alone it names when it runs included."""
    text = path.read_text(encoding="utf-8")
    found = {
        ROOT / f"{module.replace('.', '/')}.py"
        for module in re.findall(r"^\s*from plumbline\.(engine[\w.]*) import\b", text, re.MULTILINE)
    }
    for folder in re.findall(r'\bf"plumbline\.(engine\.(?:\w+\.)+)\{', text):
        found |= set((ROOT / folder.replace(".", "/")).glob("*.py"))
    return frozenset(other for other in found if other.is_file())


def orphans(page: str) -> list[str]:
    """Techniques that are reached neither from the page nor from a technique that is."""
    waiting = [ROOT / path for path in linked(page) if (ROOT / path).is_file()]
    reached = set(waiting)
    while waiting:
        more = imported(waiting.pop()) & techniques() - reached
        reached |= more
        waiting += more
    return sorted(str(path.relative_to(ROOT)) for path in techniques() - reached)


def without(page: str, concepts: Iterable[str]) -> str:
    """The page without some of its rows."""
    return "\n".join(line for line in page.splitlines() if not line.startswith(tuple(f"| {one} |" for one in concepts)))


def test_every_row_has_its_cells() -> None:
    assert len(rows(PAGE)) >= len(REQUIRED)
    assert [row for row in rows(PAGE) if len(row) != len(HEADER) or not all(row)] == []


def test_every_link_leads_to_a_file() -> None:
    assert ends_nowhere(PAGE) == []


def test_every_case_is_in_the_catalogue_or_has_a_reason() -> None:
    assert unknown_cases(PAGE) == []


@pytest.mark.parametrize(("name", "setting", "value"), sorted(set(asked(PAGE))))
def test_every_setting_is_one_that_the_case_can_be_built_with(name: str, setting: str, value: str) -> None:
    case, engine = plugins.case(name), plugins.adapter("reference")
    told = tomllib.loads(f"it = {value}")["it"]
    own = {setting: told} if setting in case.parameters else {}
    settings = engine.tracks["default"]
    if setting in ("integrator", "solver"):
        settings = replace(settings, **{setting: told}, iterations=None if told == "exact" else settings.iterations)
    elif not own:
        settings = replace(settings, options={setting: told})
    simulation = engine.build(case.scene(case.at(**own)), settings)
    used = simulation.resolved
    assert own or told in (used.integrator, used.solver, used.options.get(setting))
    simulation.close()


def test_every_concept_stands_there_once() -> None:
    assert not_once(PAGE) == []


def test_every_technique_is_reached() -> None:
    assert orphans(PAGE) == []


@pytest.mark.parametrize("page", ["README.md", "docs/architecture.md"])
def test_the_page_is_linked(page: str) -> None:
    assert "book.md)" in (ROOT / page).read_text(encoding="utf-8")


def test_a_wrong_link_is_seen() -> None:
    good = "| RK4 | `y` | [engine/world.py](../engine/world.py) | `rest_jitter` |"
    assert ends_nowhere(good) == []
    assert ends_nowhere(good.replace("world", "wold")) == ["engine/wold.py"]
    assert ends_nowhere(good.replace("(../engine/world", "(../engine/batch")) != []


def test_a_case_that_is_none_and_one_left_out_without_a_reason_are_seen() -> None:
    good = "| RK4 | `y` | [engine/world.py](../engine/world.py) | `rest_jitter` with `threads = 2` |"
    assert unknown_cases(good) == []
    assert unknown_cases(good.replace("jitter", "jiter")) == ["`rest_jiter` with `threads = 2`"]
    assert unknown_cases(good.replace("`rest_jitter` with `threads = 2`", "none")) == ["none"]


def test_a_concept_that_is_missing_or_told_twice_is_seen() -> None:
    assert not_once(without(PAGE, ["GJK"])) == ["GJK"]
    assert not_once(PAGE + "\n| EPA | `y` | [engine/world.py](../engine/world.py) | `rest_jitter` |") == ["EPA"]


@pytest.mark.parametrize(
    ("concepts", "lost"),
    [
        (["implicit midpoint"], ["engine/integrate/implicit_midpoint.py"]),
        (["sweeps at once"], ["engine/respond/jacobi.py"]),
    ],
)
def test_a_technique_that_nothing_leads_to_is_seen(concepts: list[str], lost: list[str]) -> None:
    assert orphans(without(PAGE, concepts)) == lost
