"""The reference engine still does what it did, to the last bit: on every processor, with any libraries, on any threads."""

import math
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import platformdirs
import pytest

from plumbline.engine.compile.jit import cache_directory, jit_is_off
from plumbline.harness.study.library_variants import LIBRARY_VARIANTS, LibraryVariant, obstacle
from tests.architecture.test_arithmetic import LIBRARY
from tests.golden.engine_states import WORLDS, difference, digest, known, last_state, machine, states_elsewhere

ROOT = Path(__file__).parents[2]
MATHS = (
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "erf", "exp", "exp2", "expm1", "fmod"),
    *("hypot", "log", "log10", "log1p", "log2", "pow", "sin", "sincos", "sinh", "tan", "tanh", "tgamma"),
)  # fmt: skip
"""Functions of the C library whose last bit is its own."""
PROCESSORS = {
    "x86-64": "", "haswell": "+avx2,+fma", "skylake-avx512": "+avx2,+fma,+avx512f,+avx512vl,+avx512dq,+avx512bw",
    "znver4": "+avx2,+fma,+avx512f,+avx512vl,+avx512dq,+avx512bw,+avx512vnni",
    "znver5": "+avx2,+fma,+avx512f,+avx512vl,+avx512dq,+avx512bw,+avx512vnni",
    "sapphirerapids": "+avx2,+fma,+avx512f,+avx512vl,+avx512dq,+avx512bw,+avx512vnni",
}  # fmt: skip
"""Processors, and what code for them asks of this one. The first has no instruction for a product and a sum rounded once."""
OFTEN = ("x86-64", "haswell")
SOME = ("free_box", "tree", "spheres")
SHARED = {"PLUMBLINE_KERNEL_CACHE": os.environ.get("PLUMBLINE_KERNEL_CACHE") or platformdirs.user_cache_dir("plumbline")}
"""Where the kernels of this process lie: they need not be compiled once more for another library."""
NUMPY = "NPY_DISABLE_CPU_FEATURES"


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_ends_in_the_state_it_always_ended_in(name: str) -> None:
    """Bit for bit, on every machine; what differs is said."""
    assert difference(name, last_state(name, 1)) == ""


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_ends_in_the_same_state_on_any_number_of_threads(name: str) -> None:
    assert {digest(last_state(name, threads)) for threads in (2, 4)} == {known()["hashes"][name]}


def test_a_bit_that_differs_is_named_with_its_body_and_the_machine() -> None:
    state = last_state("free_box", 1)
    state[0, 8] = np.nextafter(state[0, 8], math.inf)
    told = difference("free_box", state)
    assert "v_WB of body 0" in told
    assert "1 units in the last place off; 1 of 13 numbers differ" in told
    assert machine() in told


def unable(features: str) -> str:
    """Why this processor cannot run code with such features; empty if it can."""
    has = dict(llvm.get_host_cpu_features())
    missing = [one for one in features.replace("+", "").split(",") if one and not has.get(one)]
    return f"{llvm.get_host_cpu_name()} has no {', '.join(missing)}" if missing else ""


@pytest.mark.compiler
@pytest.mark.skipif(jit_is_off() or platform.machine() != "x86_64", reason="asks code for x86")
@pytest.mark.parametrize(
    "names", [SOME, pytest.param(tuple(set(WORLDS) - set(SOME)), marks=pytest.mark.slow)], ids=["some", "rest"]
)
@pytest.mark.parametrize(
    "processor", [one if one in OFTEN else pytest.param(one, marks=pytest.mark.slow) for one in PROCESSORS]
)
def test_code_for_another_processor_ends_in_the_same_states(processor: str, names: tuple[str, ...]) -> None:
    """Nothing is rounded otherwise by what a processor is quick at: not even by one without a fused product."""
    why = unable(PROCESSORS[processor])
    if why:
        pytest.skip(why)
    target = {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": PROCESSORS[processor]}
    assert states_elsewhere(target, names) == {name: known()["hashes"][name] for name in names}


@pytest.mark.compiler
@pytest.mark.skipif(jit_is_off(), reason="compiled code is asked for")
def test_a_processor_that_nobody_knows_is_refused() -> None:
    with pytest.raises(RuntimeError, match=r"(?i)cpu|processor"):
        states_elsewhere({"NUMBA_CPU_NAME": "abacus", "NUMBA_CPU_FEATURES": ""}, ["free_box"])


@pytest.mark.skipif(platform.machine() != "x86_64", reason="sets what libraries choose by on x86")
@pytest.mark.parametrize("variant", LIBRARY_VARIANTS, ids=lambda variant: variant.name)
def test_a_library_that_rounds_otherwise_changes_no_state(variant: LibraryVariant) -> None:
    if why := obstacle(variant.variables):
        pytest.skip(why)
    asked = {name: _present(value) if name == NUMPY else value for name, value in variant.variables}
    found = states_elsewhere({**SHARED, **asked}, list(WORLDS), "-W", "error::ImportWarning")
    assert found == known()["hashes"]


def _present(features: str) -> str:
    """Those of some features that this processor has: NumPy ignores, with a warning, what it could not use anyway."""
    from numpy._core._multiarray_umath import __cpu_features__

    known_features: dict[str, Any] = __cpu_features__
    unknown = [one for one in features.split() if one not in known_features]
    assert not unknown, f"NumPy {np.__version__} does not know {unknown}: name its features anew"
    return " ".join(one for one in features.split() if known_features[one])


LIBRARY_FREE = """
import math
import numpy
import scipy.spatial
from tests.architecture.test_arithmetic import LIBRARY
from tests.golden.engine_states import WORLDS

def refuse(name):
    def call(*_, **__):
        raise AssertionError(name + " is asked while a world is built or advanced")
    return call

for module, names in ((numpy.linalg, dir(numpy.linalg)), (numpy, {numpy}), (math, {math})):
    for name in names:
        if callable(getattr(module, name, None)) and not name.startswith("_") and not isinstance(getattr(module, name), type):
            setattr(module, name, refuse(module.__name__ + "." + name))
for build in WORLDS.values():
    build(1).step(1)
"""
"""Builds all worlds, and takes a step, where what a library would round raises. Python runs the text itself, uncompiled."""


def test_no_library_is_asked_while_worlds_are_built_and_advanced() -> None:
    text = LIBRARY_FREE.replace("{numpy}", repr(sorted(LIBRARY - {"linalg", "fft"}))).replace("{math}", repr(MATHS))
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    said = subprocess.run(
        [sys.executable, "-c", text], env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert said.returncode == 0, said.stderr


@pytest.mark.compiler
@pytest.mark.skipif(jit_is_off(), reason="asks compiled code")
def test_compiled_steps_call_nothing_of_the_c_library_that_rounds() -> None:
    """By the names that their machine code leaves to be found: `fma` is one where a processor has no instruction for it."""
    for name in WORLDS:
        last_state(name, 1)
    sources = sorted((ROOT / "src" / "plumbline" / "engine").rglob("*.py"))
    files = {file for source in sources for file in cache_directory(source).glob("*.nbc")}
    assert len(files) > len(WORLDS)
    asked = {file.name: [one for one in MATHS if f"\0{one}\0".encode() in file.read_bytes()] for file in files}
    assert {name: found for name, found in asked.items() if found} == {}


@pytest.mark.compiler
@pytest.mark.skipif(jit_is_off(), reason="asks compiled code")
def test_a_name_that_the_c_library_knows_is_seen_in_machine_code(tmp_path: Path) -> None:
    """What the test above looks for is there, where a function is asked for."""
    text = "import math, numba\n\n@numba.njit(cache=True)\ndef f(x):\n    return math.sin(x)\n\nf(1.0)\n"
    (tmp_path / "asks.py").write_text(text)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, str(tmp_path / "asks.py")], env=environment, check=True)
    (file,) = tmp_path.rglob("*.nbc")
    assert b"\0sin\0" in file.read_bytes()
