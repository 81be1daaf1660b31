"""What the engine uses of Numba beyond what Numba documents: in one file, which no test needs but those of its own speed."""

import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from plumbline.engine.compile.jit import LINKED, SWITCH, jit_is_off, linker
from tests.golden.engine_states import known, states_elsewhere

ROOT = Path(__file__).parents[2]
OWN = re.compile(r"numba\.(core|np|cpython|typed|experimental|misc)\b")


def test_one_file_names_what_numba_does_not_document() -> None:
    """But for two functions of arrays that a table's type needs, and what every compilation imports."""
    found = {
        path.relative_to(ROOT).as_posix(): set(OWN.findall(path.read_text(encoding="utf-8")))
        for package in ("engine", "adapters", "harness", "cases", "reports")
        for path in (ROOT / package).rglob("*.py")
    }
    assert {name for name, parts in found.items() if "core" in parts} == {"engine/compile/linker.py"}
    assert {name for name, parts in found.items() if parts} <= {
        *("engine/compile/linker.py", "engine/compile/table_type.py", "engine/compile/jit.py")
    }


def test_the_version_in_the_lock_file_is_one_that_the_linker_knows() -> None:
    locked = re.search(r"^numba==(\d+\.\d+)\.\d+ ", (ROOT / "requirements.lock").read_text(), re.MULTILINE)
    assert locked is not None
    assert locked[1] in LINKED


@pytest.mark.compiler
@pytest.mark.skipif(jit_is_off(), reason="asks compiled code")
def test_an_unknown_version_is_compiled_by_numba_alone() -> None:
    text = (
        "import numba; numba.__version__ = '99.0.0'\n"
        "from plumbline.engine.compile.jit import linker, kernel\n"
        "assert linker() is None\n"
        "f = kernel(lambda x: x + 1.0); print(numba.njit(lambda x: f(x))(1.0))"
    )
    said = subprocess.run([sys.executable, "-c", text], cwd=ROOT, check=True, capture_output=True, text=True)
    assert said.stdout.split() == ["2.0"]


@pytest.mark.compiler
@pytest.mark.skipif(jit_is_off(), reason="asks compiled code")
@pytest.mark.parametrize("names", [("free_box",), pytest.param(("tree", "stack"), marks=pytest.mark.slow)])
def test_without_the_linker_worlds_end_in_the_same_states(names: tuple[str, ...]) -> None:
    assert states_elsewhere({SWITCH: "off"}, names) == {name: known()["hashes"][name] for name in names}


def test_the_linker_is_on_here_unless_it_was_switched_off() -> None:
    known_version = version("numba").rpartition(".")[0] in LINKED
    assert (linker() is not None) == (known_version and not jit_is_off() and os.environ.get(SWITCH) != "off")
