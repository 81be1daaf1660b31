"""Installed, is everything of ours in one package, and does nothing of a user's come before it?"""

import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("adapters", "cases", "engine", "findings", "harness", "reports")
BARE = re.compile(rf"^\s*(?:from|import) (?:{'|'.join(ROOMS)})\b", re.MULTILINE)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--quiet",
        "--no-deps",
        "--no-build-isolation",
        "--no-index",
        "-w",
        str(folder),
        str(ROOT),
    ]
    subprocess.run(command, check=True, capture_output=True)
    return next(folder.glob("plumbline-*.whl"))


def test_the_wheel_holds_one_package_with_every_file_of_every_room(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0] for name in names if ".dist-info/" not in name} == {"plumbline"}
    listed = subprocess.run(["git", "ls-files", *ROOMS], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split(
        "\n"
    )
    assert {f"plumbline/{name}" for name in listed if name} <= set(names)


def test_packages_of_those_names_beside_the_wheel_are_never_imported(wheel: Path, tmp_path: Path) -> None:
    """Six packages that raise on import, in the folder that is worked in and first on the path, as a user's `cases/` is."""
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    for room in ROOMS:
        (tmp_path / "user" / room).mkdir(parents=True)
        (tmp_path / "user" / room / "__init__.py").write_text("raise RuntimeError('the user\\'s own package')\n")
    path = os.pathsep.join((str(tmp_path / "user"), str(tmp_path / "site")))
    done = subprocess.run(
        [sys.executable, "-m", "plumbline", "cases", "--json"],
        cwd=tmp_path / "user",
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len(json.loads(done.stdout)) == len(list((ROOT / "cases").glob("[!_]*.py")))


def test_no_file_of_ours_imports_a_room_by_its_bare_name() -> None:
    """In the root of a checkout that works by chance, and gives a second module of the same file."""
    files = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    assert [name for name in files if BARE.search((ROOT / name).read_text(encoding="utf-8"))] == []


def test_engines_are_found_from_any_folder(tmp_path: Path) -> None:
    asks = "import sys; from plumbline.harness.study import plugins; plugins.adapters(); assert 'adapters' not in sys.modules"
    subprocess.run([sys.executable, "-c", asks], cwd=tmp_path, check=True)
