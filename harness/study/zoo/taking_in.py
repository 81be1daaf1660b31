"""Taking a robot in: its file is read with the least left out, then each engine asked for the least that lets it in.

What one engine lacks is left out for all, so that all run the same robot: each that has it is also run with it, and what the
omission changes is a number then (`harness.search.refined_ladder`).
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import chain, combinations
from pathlib import Path
from typing import Literal

from plumbline.harness.adapter import Unavailable, Unsupported
from plumbline.harness.case.undropped import KINDS
from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.intake.error import PlumblineError, RobotError
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene import Prismatic, Revolute, Scene
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.imported import Imported
from plumbline.harness.scene.importers.reading import imported, robot_of
from plumbline.harness.scene.importers.robot import Robot as FileRobot
from plumbline.harness.scene.importers.settling import wordless_kinds
from plumbline.harness.store.imported_scenes import keep
from plumbline.harness.store.record import checked
from plumbline.harness.store.zoo_record import InEngine, Stage, ZooEntry
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import elsewhere, project_folders
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.zoo.robots import NotHere, ZooRobot, file_of, roots_of

Verdict = Literal["can", "cannot", "unavailable", "failed"]


def expressed_apart(engine: str, scene: Scene) -> tuple[Verdict, str]:
    """Can an engine build a scene, on its track 'tuned'? With the reason where it cannot, or where it gave no answer."""
    adapter = plugins.adapter(engine)
    _, reason = plugins.version_of(adapter)
    if reason is not None:
        return "unavailable", reason
    allowed = Experiment(name="build").deadline + adapter.compile_allowance
    form, home = tuple[Verdict, str], elsewhere(engine)
    try:
        if home is None:
            return apart(form, allowed, expressed, engine, scene)
        return apart(form, allowed, expressed, engine, scene, interpreter=home.executable, path=project_folders())
    except NoAnswer as error:
        return "failed", f"build {error}"


def expressed(engine: str, scene: Scene) -> tuple[Verdict, str]:
    """The same, in the process that is given up to it."""
    adapter = plugins.adapter(engine)
    try:
        simulation: object = adapter.build(scene, adapter.tracks["tuned"])
        if simulation is None:
            return "failed", "build gave None, expected a Simulation"
        simulation.close()  # type: ignore[attr-defined]  # what it is is for `plumbline check`
    except Unavailable as error:
        return "unavailable", str(error)
    except Unsupported as error:
        return "cannot", str(error)
    return "can", ""


Drops = frozenset[str]


def least(works: Callable[[Drops], bool], kinds: Collection[str]) -> Drops | None:
    """A set of kinds that has to go for something to work, of which none can stay: the first in alphabetical order stay first.

    Something works without more wherever it works without less. Returns: None where it does not work without all of them.
    """
    if works(frozenset()):
        return frozenset()
    left_out = frozenset(kinds)
    if not works(left_out):
        return None
    for kind in sorted(kinds):
        if works(left_out - {kind}):
            left_out -= {kind}
    return left_out


def subsets(kinds: Collection[str]) -> list[Drops]:
    """All sets of some of these kinds, the small ones first."""
    ordered = sorted(kinds)
    return [frozenset(each) for each in chain.from_iterable(combinations(ordered, size) for size in range(len(ordered) + 1))]


def least_for(engine: str, scenes: Mapping[Drops, Scene]) -> tuple[Verdict, list[str], str]:
    """What has to be left out for an engine to build a scene, in a process that is given up to it.

    Args: scenes: by what they leave out, one for each set of some kinds. Returns: the verdict, what is left out, and why an
    engine cannot, or what it says of the scene with nothing left out.
    """
    answers: dict[Drops, tuple[Literal["can", "cannot", "unavailable", "failed"], str]] = {}

    def works(drops: Drops) -> bool:
        if drops not in answers:
            answers[drops] = expressed(engine, scenes[drops])
        return answers[drops][0] == "can"

    everything = max(scenes, key=len)
    drops = least(works, everything)
    if drops is None:
        verdict, reason = answers[everything]
        return verdict, [], reason
    return "can", sorted(drops), answers[frozenset()][1] if drops else ""


PATIENCE = 600.0
"""Seconds that a file may take to be read, its meshes among them."""
WORDED = frozenset((*KINDS.values(), "self_collision", "tendon"))
"""What a scene has words for and not every engine can express."""
DURATION = 1.0
"""Seconds of a run."""


def take_in(folder: Path, robot: ZooRobot, engines: Sequence[str], key: str) -> ZooEntry:
    """What became of a robot, whose scene is kept in the run folder where it goes in.

    Args: engines: names of those that are asked. key: what the answer rests on.
    """
    about = unread(robot, key)
    try:
        stage, fields = apart(tuple[Stage, dict[str, object]], PATIENCE, read_apart, folder, robot, tuple(engines))
    except NoAnswer as error:
        return replace(about, stage="not read", reason=str(error))
    if stage != "in":
        return replace(about, stage=stage, reason=str(fields["reason"]))
    return checked(ZooEntry, {**asdict(about), "stage": "in", **fields}, "robot of a zoo")


def unread(robot: ZooRobot, key: str) -> ZooEntry:
    """The entry of a robot of which nothing is known but what its package says."""
    return ZooEntry(
        name=robot.name,
        title=robot.title,
        package=robot.package,
        version=robot.version,
        licence=robot.licence,
        file=robot.file,
        key=key,
    )


def read_apart(folder: Path, robot: ZooRobot, engines: Sequence[str]) -> tuple[Stage, dict[str, object]]:
    """As `take_in`, in the process that is given up to one robot: how far it came, and the fields of its entry."""
    try:
        path = file_of(robot)
    except NotHere as error:
        return "not here", {"reason": str(error)}
    try:
        read, scenario, needed, kinds = _read(path, robot)
        verdicts = [_in_engine(engine, {drops: read[needed | drops].scene for drops in subsets(kinds)}) for engine in engines]
    except PlumblineError as error:
        return "refused", {"reason": str(error).replace(f"{path.parent}/", "")}
    admitted = [each for each in verdicts if each.verdict == "can"]
    if not admitted:
        return "no engine", {"reason": "; ".join(f"{each.engine}: {each.reason}" for each in verdicts)}
    dropped = needed | {kind for each in admitted for kind in each.drops}
    taken = replace(read.looking(dropped), name=f"{robot.title}, {robot.package}", duration=DURATION)
    scene = keep(folder, taken)
    return "in", {
        "scene": str(scene.relative_to(folder)),
        "scenario": scenario,
        "needed": sorted(needed),
        "dropped": sorted(dropped),
        "engines": [asdict(each) for each in verdicts],
        "bodies": sum(body.movable for body in taken.scene.bodies),
        "joints": len(taken.scene.joints),
    }


class _Reads:
    """The scenes of one robot, each by what it leaves out. It is read once and made a scene as often as asked."""

    def __init__(self, robot: FileRobot, companion: Companion, wishes: Wishes) -> None:
        self._robot, self._companion, self._wishes = robot, companion, wishes
        self._made: dict[Drops, Imported] = {}

    def __getitem__(self, drops: Drops) -> Imported:
        """Raises: RobotError."""
        if drops not in self._made:
            self._made[drops] = self._import(drops, looks=False)
        return self._made[drops]

    def looking(self, drops: Drops) -> Imported:
        """The same with what is drawn of it. Raises: RobotError."""
        return self._import(drops, looks=True)

    def reads(self, drops: Drops) -> bool:
        """Is there such a scene?"""
        try:
            self[drops]
        except RobotError:
            return False
        return True

    def _import(self, drops: Drops, *, looks: bool) -> Imported:
        return imported(self._robot, self._companion, replace(self._wishes, drop=drops, looks=looks))


def _read(path: Path, robot: ZooRobot) -> tuple[_Reads, str, Drops, frozenset[str]]:
    """The robot of a file, its scenario, what has to be left out of it to be a scene at all, and what else may be.

    A robot with a floating root is dropped, one whose root is fixed swings. Raises: RobotError.
    """
    of_file, _, wishes = robot_of(path, Wishes(root=robot.companion.root, packages=roots_of(robot)))
    floats = robot.companion.root == "floating" or any(c.kind == "free" for link in of_file.links for c in link.coordinates)
    scenario = "drop" if floats else "swing"
    read = _Reads(of_file, robot.companion, replace(wishes, scenario="drop" if floats else "swing"))
    needed = least(read.reads, wordless_kinds(of_file) | WORDED)
    if needed is None:
        read[frozenset(wordless_kinds(of_file) | WORDED)]
        raise RobotError(f"{robot.file}: it cannot be read")
    return read, scenario, needed, kinds_of(read[needed].scene) - needed


def kinds_of(scene: Scene) -> Drops:
    """The kinds of `WORDED` that a scene has."""
    joints = [joint for joint in scene.joints if isinstance(joint, Revolute | Prismatic)]
    kinds = {kind for field, kind in KINDS.items() if any(getattr(joint, field) for joint in joints)}
    touching = [body for body in scene.bodies if body.movable and body.collision]
    within = any(scene.collides(a, b) for a, b in combinations(touching, 2))
    return frozenset(kinds | ({"self_collision"} if within else set()) | ({"tendon"} if scene.tendons else set()))


def _in_engine(engine: str, scenes: dict[Drops, Scene]) -> InEngine:
    """The least that lets an engine in."""
    adapter = plugins.adapter(engine)
    _, reason = plugins.version_of(adapter)
    if reason is not None:
        return InEngine(engine=engine, verdict="unavailable", reason=reason)
    allowed = Experiment(name="build").deadline + adapter.compile_allowance
    home, form = elsewhere(engine), tuple[Verdict, list[str], str]
    try:
        if home is None:
            verdict, drops, words = apart(form, allowed, least_for, engine, scenes)
        else:
            path = project_folders()
            verdict, drops, words = apart(form, allowed, least_for, engine, scenes, interpreter=home.executable, path=path)
    except NoAnswer as error:
        return InEngine(engine=engine, verdict="failed", reason=f"build {error}")
    return InEngine(engine=engine, verdict=verdict, drops=tuple(drops), reason=words)
