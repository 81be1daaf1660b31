"""The digests that name the engine's code follow every file that they are about, and no other."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import plumbline.engine.compile.sources as sources
from plumbline import engine

ROOT = Path(engine.__file__).parent
FILES = {
    "__init__.py": "from plumbline.engine.a import one\n",
    "a.py": "one = 1\n",
    "b.py": "two = 2\n",
    "room/__init__.py": "",
    "room/direct.py": "from plumbline.engine.a import (\n    one,\n)\n",
    "room/late.py": "def f():\n    from plumbline.engine import b as other\n    return other\n",
    "room/through.py": "import plumbline.engine.room.late\n",
    "room/alone.py": "import math\n",
}

Digest = Callable[[str], str]


@pytest.fixture
def digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Digest:
    """The digest of a file of a small package, '' for all of it; files may be written in between."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(sources, "__file__", str(tmp_path / "compile" / "sources.py"))

    def now(name: str) -> str:
        for kept in (sources._modules, sources._content, sources._imported):
            kept.cache_clear()
        return sources.closure_digest(tmp_path / name) if name else sources.source_digest()

    return now


def test_another_byte_in_any_file_is_another_digest(digest: Digest, tmp_path: Path) -> None:
    first = digest("")
    assert digest("") == first
    (tmp_path / "room" / "alone.py").write_text("x = 2\n")
    second = digest("")
    (tmp_path / "room" / "alone.py").rename(tmp_path / "room" / "other.py")
    assert len({first, second, digest("")}) == 3


@pytest.mark.parametrize(
    ("edited", "reached"),
    [
        ("a.py", {"room/direct.py", "room/late.py", "room/through.py"}),  # by the face too, of which `late` takes a module
        ("b.py", {"room/late.py", "room/through.py"}),
        ("room/late.py", {"room/late.py", "room/through.py"}),
        ("room/alone.py", {"room/alone.py"}),
        ("room/__init__.py", {"room/alone.py", "room/direct.py", "room/late.py", "room/through.py"}),
    ],
)
def test_an_edit_is_seen_by_what_imports_it_and_by_nothing_else(
    edited: str, reached: set[str], digest: Digest, tmp_path: Path
) -> None:
    names = [name for name in FILES if name.startswith("room/") and not name.endswith("__init__.py")]
    before = {name: digest(name) for name in names}
    (tmp_path / edited).write_text(FILES[edited] + "# edited\n")
    assert {name for name in names if digest(name) != before[name]} == reached


MODULES = (
    "plumbline.engine.steps.contact",
    "plumbline.engine.rays.tiles",
    "plumbline.engine.broad.octree",
    "plumbline.engine.swept.strike",
)
IMPORTS = """
import sys
for module in sys.argv[1:]:
    for name in [name for name in sys.modules if f"{name}.".startswith("plumbline.engine.")]:
        del sys.modules[name]
    __import__("plumbline.engine")
    before = set(sys.modules)
    __import__(module)
    print(*sorted(set(sys.modules) - before))
"""
"""Each module imported beside nothing but the face; a line of what that loads."""


@pytest.fixture(scope="module")
def loads() -> dict[str, set[str]]:
    """The modules of the engine that an import of each of `MODULES` loads."""
    given = [sys.executable, "-c", IMPORTS, *MODULES]
    lines = subprocess.run(given, capture_output=True, text=True, check=True, cwd=ROOT.parent).stdout.splitlines()
    loaded = ({name for name in line.split() if name.startswith("plumbline.engine.")} for line in lines)
    return dict(zip(MODULES, loaded, strict=True))


@pytest.mark.parametrize("module", MODULES)
def test_what_an_import_really_loads_is_in_the_closure(module: str, loads: dict[str, set[str]]) -> None:
    loaded = loads[module]
    path = ROOT.joinpath(*module.split(".")[2:]).with_suffix(".py")
    files = {str(Path(name).relative_to(ROOT)) for name in sources.closure(path)}
    inside = {"plumbline.engine." + name.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for name in files}
    assert module in loaded
    assert loaded <= inside
