"""What became of each robot of a zoo: one sealed file a robot in the run folder, which a later run of it goes on from."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile
from plumbline.harness.store.record import checked
from plumbline.harness.store.store import read_plain, write_json

FOLDER = "zoo"
Stage = Literal["in", "not here", "not read", "refused", "no engine"]
"""How far a robot came: it runs; its files could not be had; reading them did not end; they are refused; no engine can build
it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InEngine:
    """One engine and a robot.

    Terms: verdict: can it build the robot? drops: the least that has to be left out for that, beyond what no scene has words
    for. reason: why it cannot; of one that can, what it says of the robot with nothing left out, '' where it takes all of it.
    """

    engine: str
    verdict: Literal["can", "cannot", "unavailable", "failed"]
    drops: tuple[str, ...] = ()
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ZooEntry:
    """One robot.

    Terms: name: unique in a zoo. package, version: what brought it along. licence: in the package's words. file: within the
    package. key: what this answer rests on. reason: why it does not go in. scene: its file within the run folder. scenario:
    what happens to it. needed: kinds of elements without which alone it is a scene; dropped: all that is left out of what is
    run. bodies: that move. joints: of the scene.
    """

    name: str
    title: str
    package: str
    version: str
    licence: str
    file: str
    key: str
    stage: Stage = "not here"
    reason: str = ""
    scene: str = ""
    scenario: str = ""
    needed: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    engines: tuple[InEngine, ...] = ()
    bodies: int = 0
    joints: int = 0


CURE = "delete it; run zoo with --resume takes that robot in anew"
"""What to do about a file here that is not as it was written."""


def write(folder: Path, entry: ZooEntry) -> None:
    """Keep an entry. Raises: OSError."""
    disk.make_folder(folder / FOLDER)
    write_json(folder / FOLDER / f"{entry.name}.json", asdict(entry))


def entries(folder: Path) -> Iterator[ZooEntry]:
    """The entries of a run folder in the order of their names; none of one that is no zoo's. Raises: DamagedFile."""
    for path in sorted((folder / FOLDER).glob("*.json")):
        yield _read(path)


def unsound(folder: Path) -> Iterator[tuple[Path, str]]:
    """The files of the folder that are not as they were written, each with what is wrong."""
    for path in sorted((folder / FOLDER).glob("*")):
        try:
            if path.suffix != ".json":
                raise DamagedFile(path, "is no robot of a zoo", CURE)
            _read(path)
        except DamagedFile as error:
            yield path, error.what
        except OSError as error:
            yield path, str(error)


def _read(path: Path) -> ZooEntry:
    try:
        entry = checked(ZooEntry, read_plain(path), "robot of a zoo")
        if f"{entry.name}.json" != path.name:
            raise ValueError(f"it is of robot {entry.name!r}")
    except ValueError as error:
        raise DamagedFile(path, str(error), CURE) from None
    return entry
