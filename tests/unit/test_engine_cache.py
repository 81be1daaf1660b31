"""The kernel cache: an edit of any function is seen, what did not change is not compiled again; and no compiler is needed."""

import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.compile.jit import cache_directory, linker
from plumbline.engine.compile.kernel_cache import read_checked, write_checked
from plumbline.engine.steps import smooth
from tests.forks import forks

pytestmark = [
    pytest.mark.compiler,
    pytest.mark.skipif(linker() is None, reason="the cache is Numba's own where it links nothing"),
]

TUMBLE = """
import numpy as np
from plumbline import engine
world = engine.World([engine.Body(name="b", inertia=np.diag([1.0, 2.0, 3.0]), w_WB=(0.01, 5.0, 0.02), v_WB=(1.0, 0.5, 3.0))])
world.step(240)
print(world.state().tobytes().hex(), sum(world._step.stats.cache_hits.values()))
"""
"""The bits of a body that falls and tumbles for a second, and how many compiled functions came from the cache."""
ROLL = """
import numpy as np
from plumbline import engine
rng = np.random.default_rng(5)
ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
shapes = (engine.Box((0.1, 0.08, 0.12)), engine.Capsule(0.06, 0.1), engine.Cylinder(0.08, 0.1))
bodies = [
    engine.Body(
        name=f"b{k}", inertia=np.diag([0.01, 0.012, 0.014]), shapes=[engine.Placed(shapes[k % 3])], q_WB=rng.normal(size=4),
        p_WB=(3.0 * (k % 2), 0.1 * rng.uniform(), 0.2 + 0.12 * k),
    )
    for k in range(6)
]
world = engine.World([ground, *bodies], options=engine.Options(threads=2))
world.step(240)
print(world.state().tobytes().hex(), sum(world._step.stats.cache_hits.values()))
"""
"""As TUMBLE, of two heaps, each on a thread."""
KICK = "g = load3(setting, 0, at.GRAVITY)"
MADE = {
    "__init__.py": "",
    "pull.py": """
from plumbline.engine.compile.jit import kernel

@kernel
def pull(time: float) -> float:
    return -9.81 * time
""",
    "sink.py": """
from plumbline.engine.compile.jit import entry
from plumbline.engine.made.pull import pull

@entry
def sink(speed: float, steps: int) -> float:
    for _ in range(steps):
        speed += pull(1 / steps)
    return speed
""",
}
"""The modules of a step that is compiled in no time and, as the engine's own, calls a kernel of another module."""
SINK = """
import numpy as np
from plumbline.engine.made.sink import sink
state = np.zeros(13)
state[9] = sink(3.0, 240)
print(state.tobytes().hex(), sum(sink.stats.cache_hits.values()))
"""
"""As TUMBLE, of that step."""
COMPILER = "import numba; numba.njit(lambda x: x)(1.0)"
"""What all processes do that compile."""
FEW = (
    "test_engine_motion.py::test_damping_decays_exponentially",
    "test_engine_motion.py::test_without_the_gyroscopic_effect_the_spin_is_constant",
    "test_engine_input.py::test_a_world_in_contact_that_diverges_says_in_which_step",
)
"""Tests of free bodies and of every solver's contacts that pass within a second as plain Python."""
MORE = ("test_engine_motion.py", "test_engine_input.py", "test_engine_world.py")
"""Files of such tests that take seconds."""


def _copied(root: Path) -> Path:
    source = Path(engine.__file__).parent
    shutil.copytree(source, root / "plumbline" / "engine", ignore=shutil.ignore_patterns("__pycache__"))
    (root / "plumbline" / "__init__.py").touch()
    return root


def _run(root: Path, script: str) -> tuple[str, int]:
    """Run the copy in a process of its own. Returns: the bits of the state that it ends in, hits of the cache."""
    said = subprocess.run(
        [sys.executable, "-B", "-c", script],
        cwd=root,
        env=os.environ | {"PYTHONPATH": str(root), "PLUMBLINE_KERNEL_CACHE": str(root / "cache"), "NUMBA_DISABLE_JIT": "0"},
        check=True,
        capture_output=True,
        text=True,
    ).stdout.split()
    return said[0], int(said[1])


def _upwards(state: str, hits: int) -> tuple[float, int]:
    """Velocity [m/s] upwards after a second, hits of the cache."""
    return float(np.frombuffer(bytes.fromhex(state))[9]), hits


DOWN, UP = pytest.approx(3.0 - 9.81), pytest.approx(3.0 + 9.81)
"""Velocities [m/s] after a second of gravity, as it is and turned round."""


@pytest.fixture(scope="module")
def fallen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources, written at another time, and the step of free fall that is in this process's cache: a fresh
    checkout, say, beside a cache that was kept. The made step is in it too. Each test leaves it so.
    """
    engine.World([engine.Body()]).step()
    root = _copied(tmp_path_factory.mktemp("fallen"))
    (root / "plumbline" / "engine" / "made").mkdir()
    for name, text in MADE.items():
        (root / "plumbline" / "engine" / "made" / name).write_text(text)
    for path in (root / "plumbline" / "engine").rglob("*.py"):
        os.utime(path, (1e9, 1e9))
    kept = cache_directory(Path(smooth.__file__))
    shutil.copytree(kept, root / "cache" / kept.name)
    return root


Program = Callable[[str], tuple[str, int]]


@pytest.fixture(scope="module")
def run(fallen: Path) -> Iterator[Program]:
    """As `_run` of the copy, in processes that have compiled something already."""
    with forks(COMPILER) as fork:

        def answer(script: str) -> tuple[str, int]:
            state, hits = fork(script, str(fallen), PLUMBLINE_KERNEL_CACHE=str(fallen / "cache")).split()
            return state, int(hits)

        yield answer


@pytest.fixture(scope="module")
def first(run: Program) -> tuple[str, int]:
    """What the step of free fall ends in before any test has touched the copy."""
    return run(TUMBLE)


@dataclass(frozen=True)
class Step:
    """A step of the copy: the program that makes it, what that says before any test has touched the copy, its module, and a
    line of a kernel that it calls from another module, with an edit that turns gravity round."""

    program: str
    whole: str
    module: str
    kernel: Path
    edit: tuple[str, str]


@pytest.fixture(scope="module")
def own(fallen: Path, first: tuple[str, int]) -> Step:
    """The step of free fall."""
    kernel = fallen / "plumbline" / "engine" / "integrate" / "semi_implicit_euler.py"
    return Step(TUMBLE, first[0], "smooth", kernel, (KICK, KICK.replace("load3", "scale(-1.0, load3") + ")"))


@pytest.fixture(scope="module")
def made(fallen: Path, run: Program) -> Step:
    """The made step, compiled by the first process that asks for it."""
    whole, hits = run(SINK)
    assert hits == 0
    return Step(SINK, whole, "sink", fallen / "plumbline" / "engine" / "made" / "pull.py", ("-9.81", "9.81"))


@pytest.fixture(params=["made", pytest.param("own", marks=pytest.mark.slow)])
def step(request: pytest.FixtureRequest) -> Step:
    """Either of them."""
    found: Step = request.getfixturevalue(request.param)
    return found


def test_the_same_sources_in_another_folder_written_at_another_time_are_not_compiled_again(first: tuple[str, int]) -> None:
    assert _upwards(*first) == (DOWN, 1)


@pytest.mark.slow
def test_the_process_that_compiles_for_two_threads_gets_the_bits_of_those_that_load(tmp_path: Path) -> None:
    copy = _copied(tmp_path)
    compiled, loaded = _run(copy, ROLL), _run(copy, ROLL)
    assert (compiled[1], loaded[1]) == (0, 1)
    assert compiled[0] == loaded[0]


def test_an_edited_callee_is_compiled_anew_and_an_unedited_one_comes_from_the_cache(
    step: Step, run: Program, fallen: Path
) -> None:
    """The edit turns gravity round in a function that the compiled step calls from another module. A cache that looks at the
    step's own file alone would go on to fall down.
    """
    text = step.kernel.read_text()
    assert text.count(step.edit[0]) == 1
    step.kernel.write_text(text.replace(*step.edit))
    assert _upwards(*run(step.program)) == (UP, 0)
    step.kernel.write_text(text)
    with (fallen / "plumbline" / "engine" / "rays" / "tiles.py").open("a") as rays:
        rays.write("# no step is made of this\n")
    assert _upwards(*run(step.program)) == (DOWN, 1)


@pytest.fixture(scope="module")
def twice() -> Any:
    """A compiled function of one number."""
    made: Any = numba.njit(**linker().OPTIONS["entry"])(lambda x: 2.0 * x)
    assert made(1.5) == 3.0
    return made


def _stored(folder: Path, twice: Any) -> tuple[Any, Callable[[], Any]]:
    """What keeps that function in a folder, which has it, and what it comes from there as."""
    kept = linker().Kept(twice.py_func, folder)
    ((signature, made),) = twice.overloads.items()
    kept.save_overload(signature, made)
    return kept, lambda: kept.load_overload(signature, twice.targetctx)


def test_stored_code_comes_back_for_its_own_types_and_python_alone(
    tmp_path: Path, twice: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, load = _stored(tmp_path, twice)
    assert load().entry_point(2.5) == 5.0
    assert kept.load_overload((numba.int64,), twice.targetctx) is None
    monkeypatch.setattr(sys.implementation, "cache_tag", "cpython-0")
    assert load() is None
    assert [path.suffix for path in tmp_path.iterdir()] == [".nbc"]


def test_damaged_code_is_named_never_loaded_and_replaced(tmp_path: Path, twice: Any) -> None:
    _, load = _stored(tmp_path, twice)
    (path,) = tmp_path.glob("*.nbc")
    whole = path.read_bytes()
    flipped = [whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :] for place in range(0, len(whole), 7)]
    write_checked(path.with_name("other.nbc"), whole[64:])
    for content in (*flipped, whole[: len(whole) // 2], b"", path.with_name("other.nbc").read_bytes()):
        path.write_bytes(content)
        with pytest.warns(RuntimeWarning, match=f"{path.name}: compiled code is damaged .* compiled anew"):
            assert load() is None
    _, load = _stored(tmp_path, twice)
    assert load().entry_point(2.5) == 5.0
    path.unlink()
    assert load() is None


def test_a_step_whose_stored_code_is_damaged_is_compiled_anew_to_the_bits_of_those_that_load(
    step: Step, run: Program, fallen: Path
) -> None:
    """What is damaged was compiled by another process; one that compiles it anew, and one that loads that, give its bits."""
    stored = list((fallen / "cache").rglob(f"{step.module}.*.nbc"))
    assert stored
    for path in stored:
        content = path.read_bytes()
        path.write_bytes(content[:-100] + bytes([content[-100] ^ 1]) + content[-99:])
    assert run(step.program) == (step.whole, 0)
    assert run(step.program) == (step.whole, 1)


def test_what_is_kept_has_the_names_that_python_asks_for_and_not_the_program() -> None:
    """The program would be read whenever its machine code is loaded, which is half of a robot's first step."""
    import llvmlite.binding as llvm

    engine.World([engine.Body(name="b")]).step()
    kept = list(cache_directory(Path(smooth.__file__)).glob("smooth.step_free*.nbc"))
    assert kept
    for path in kept:
        code, names = next(_machine_code(pickle.loads(read_checked(path) or b"")))
        functions = [one for one in llvm.parse_bitcode(names).functions if not one.is_declaration]
        assert functions
        for one in functions:
            assert [len(list(block.instructions)) for block in one.blocks] == [1]
            assert one.name.encode() in code


def _machine_code(content: Any) -> Iterator[tuple[bytes, bytes]]:
    """Of a kept overload: machine code, and the module with the names in it."""
    if isinstance(content, tuple) and len(content) == 3 and content[1] == "object":
        yield content[2]
    elif isinstance(content, tuple):
        for one in content:
            yield from _machine_code(one)


@pytest.mark.slow
@pytest.mark.parametrize("tests", [FEW, *((file,) for file in MORE)])
def test_the_unit_tests_pass_without_the_compiler(tests: tuple[str, ...]) -> None:
    """`make test-nojit` runs them all; what each solver makes of a fall is compared in `test_engine_world`."""
    here = Path(__file__).parent
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", *(str(here / name) for name in tests)],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=280,
    )
    assert ran.returncode == 0, ran.stdout[-3000:]
