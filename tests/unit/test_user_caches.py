"""What lies in a cache is taken over only where nobody else can have written it: compiled code, templates, meshes, versions."""

import ctypes
import os
import pickle
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from plumbline.adapters.reference.vendor import check_cache
from plumbline.engine.compile import kernel_cache
from plumbline.harness.adapter import Unavailable
from plumbline.harness.intake import user_cache
from plumbline.harness.study.environments import Environment, environment_of, folder_of, keep

ANOTHER = 54321
"""A user who is nobody here."""
CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, CAP_FOWNER, PR_CAPBSET_DROP = 1, 2, 3, 24
"""From linux/capability.h and linux/prctl.h: what lets root write where nobody may."""


def opened_up(path: Path) -> None:
    path.chmod(path.stat().st_mode | 0o002)


def given_away(path: Path) -> None:
    """Owned by another user, which root alone can bring about; where we are not root, who we are is changed instead."""
    if os.geteuid() == 0:
        os.chown(path, ANOTHER, -1)
    else:
        pytest.MonkeyPatch().setattr(os, "geteuid", lambda: ANOTHER)


@pytest.fixture
def myself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever `given_away` says of this user is forgotten at the end."""
    monkeypatch.setattr(os, "geteuid", os.geteuid)


@pytest.fixture
def code(tmp_path: Path) -> Path:
    kernel_cache._say_once.cache_clear()
    path = tmp_path / "kernels" / "step.nbc"
    kernel_cache.write_checked(path, pickle.dumps("machine code"))
    return path


@pytest.mark.usefixtures("myself")
@pytest.mark.parametrize("changed", [opened_up, given_away])
@pytest.mark.parametrize("what", ["file", "folder"])
def test_compiled_code_that_another_may_have_written_is_never_loaded(what: str, changed: object, code: Path) -> None:
    assert kernel_cache.read_checked(code) == pickle.dumps("machine code")
    changed(code if what == "file" else code.parent)  # type: ignore[operator]
    with pytest.warns(RuntimeWarning, match="another user owns or may write is not run; it is compiled anew"):
        assert kernel_cache.read_checked(code) is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it is said once
        assert kernel_cache.read_checked(code) is None


@pytest.mark.usefixtures("myself")
@pytest.mark.parametrize("changed", [opened_up, given_away])
def test_a_folder_that_others_may_write_is_left_for_one_of_our_own(
    changed: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(kernel_cache.VARIABLE, str(tmp_path / "cache"))
    assert kernel_cache.usable_root() == tmp_path / "cache"
    changed(tmp_path / "cache")  # type: ignore[operator]
    own = tmp_path / "cache" / f"user-{os.geteuid()}"
    assert kernel_cache.usable_root() == own
    own.chmod(0o777)
    with pytest.raises(Unavailable, match=r"^PLUMBLINE_KERNEL_CACHE: .*user-.* is another user's, or others may write to it; "):
        check_cache()


def test_what_is_made_is_for_nobody_else_to_write_whatever_the_umask(tmp_path: Path, code: Path) -> None:
    before = os.umask(0)
    try:
        kernel_cache.write_checked(tmp_path / "other" / "code" / "step.nbc", b"x")
        user_cache.keep(tmp_path / "plumbline" / "pieces" / "mesh.npz", b"x")
    finally:
        os.umask(before)
    assert kernel_cache.read_checked(tmp_path / "other" / "code" / "step.nbc") == b"x"
    assert user_cache.read_kept(tmp_path / "plumbline" / "pieces" / "mesh.npz") == b"x"
    made = [path for folder in ("other", "plumbline") for path in (tmp_path / folder, *(tmp_path / folder).rglob("*"))]
    assert len(made) == 6
    assert not [path for path in made if path.stat().st_mode & 0o022]


def test_a_folder_that_can_be_none_makes_the_engine_unavailable_with_the_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(kernel_cache.VARIABLE, str(tmp_path / "file" / "cache"))
    with pytest.raises(Unavailable, match=r"^PLUMBLINE_KERNEL_CACHE: .*: Not a directory; name a folder of your own"):
        check_cache()


FALL = """
import warnings
from plumbline import engine
from plumbline.adapters.reference.vendor import check_cache
check_cache()
world = engine.World([engine.Body(name="b")])
world.step(10)
print(world.state().tobytes().hex(), sum(world._step.stats.cache_hits.values()))
"""


def _without_privileges() -> None:
    for capability in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, CAP_FOWNER):
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)


@pytest.mark.compiler
def test_a_warm_cache_that_is_read_only_is_used_and_a_cold_one_costs_the_time_alone(tmp_path: Path) -> None:
    def fallen() -> tuple[str, int, str]:
        done = subprocess.run(
            [sys.executable, "-c", FALL],
            env=os.environ | {kernel_cache.VARIABLE: str(tmp_path), "NUMBA_DISABLE_JIT": "0"},
            preexec_fn=_without_privileges,
            capture_output=True,
            text=True,
            check=True,
        )
        state, hits = done.stdout.split()
        return state, int(hits), done.stderr

    state, hits, _ = fallen()
    assert hits == 0
    kept = [tmp_path, *tmp_path.rglob("*")]
    for path in kept:
        path.chmod(path.stat().st_mode & ~0o222)
    assert fallen() == (state, 1, "")
    for path in kept:
        path.chmod(path.stat().st_mode | 0o200)
    (stored,) = tmp_path.rglob("*.nbc")
    stored.unlink()
    for path in kept[:2]:
        path.chmod(0o555)
    assert fallen()[:2] == (state, 0)


@pytest.mark.usefixtures("myself")
@pytest.mark.parametrize("changed", [opened_up, given_away])
@pytest.mark.parametrize("what", ["file", "folder"])
def test_what_is_kept_beside_is_not_taken_over_where_another_may_have_written_it(
    what: str, changed: object, tmp_path: Path
) -> None:
    user_cache._say_once.cache_clear()
    path = tmp_path / "pieces" / "mesh.npz"
    user_cache.keep(path, b"corners")
    assert user_cache.read_kept(path) == b"corners"
    changed(path if what == "file" else path.parent)  # type: ignore[operator]
    with pytest.warns(RuntimeWarning, match="another user owns or may write is not taken over"):
        assert user_cache.read_kept(path) is None


@pytest.mark.parametrize("content", [b"", b"corners", b"\0" * 40])
def test_what_is_damaged_is_not_taken_over(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "pieces" / "mesh.npz"
    user_cache.keep(path, b"corners")
    path.write_bytes(content)
    assert user_cache.read_kept(path) is None


@pytest.mark.usefixtures("myself")
@pytest.mark.parametrize("changed", [opened_up, given_away])
def test_an_interpreter_that_another_may_have_named_is_not_run(
    changed: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLUMBLINE_ENVIRONMENTS", str(tmp_path))
    before = os.umask(0o002)
    try:
        keep("mujoco 3.3.0", Environment(executable="/bin/true", version="3.3.0"))
    finally:
        os.umask(before)
    found = environment_of("mujoco 3.3.0")
    assert found is not None
    assert found.executable == "/bin/true"
    changed(folder_of("mujoco 3.3.0") / "environment.json")  # type: ignore[operator]
    assert environment_of("mujoco 3.3.0") is None
