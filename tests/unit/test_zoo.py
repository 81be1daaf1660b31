"""A zoo: robots of packages, the least that is left out of each, what is kept of them, and what a run of them says."""

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.cli.zoo_run import carried_out, zoo_robots
from plumbline.harness.findings import tables
from plumbline.harness.findings.tables.zoo import NOT_RUN
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.run import zoo_intake
from plumbline.harness.run.verify import problems
from plumbline.harness.run.zoo_intake import RobotByRobot, taken_in
from plumbline.harness.store import zoo_record
from plumbline.harness.store.journal import DamagedFile, FolderTaken
from plumbline.harness.store.store import Store
from plumbline.harness.store.zoo_record import ZooEntry
from plumbline.harness.study import plugins
from plumbline.harness.study.zoo.robots import LIST, MENAGERIE, NotHere, ZooRobot, chosen, file_of, robots
from plumbline.harness.study.zoo.taking_in import least, subsets
from plumbline.reports.page import pages
from plumbline.reports.pages.zoo import PAGE
from tests.in_process import clocked_by, in_this_process
from tests.tiny_zoo import NAME, tiny_zoo

ENGINES = ("dart", "mujoco", "reference")
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("zoo")


@pytest.fixture(scope="module")
def tiny(folder: Path) -> Iterator[list[ZooRobot]]:
    with tiny_zoo(folder) as found:
        yield found


@pytest.fixture(scope="module")
def taken(folder: Path, tiny: list[ZooRobot]) -> dict[str, ZooEntry]:
    return {entry.name: entry for entry in taken_in(folder / "run", tiny, ENGINES, workers=2)}


def test_what_is_left_out_is_the_least_and_none_of_it_can_stay() -> None:
    """Something works without b and c, or without d: with all there, what comes first in the alphabet is put back first."""

    def works(left_out: frozenset[str]) -> bool:
        return left_out >= {"b", "c"} or "d" in left_out

    assert least(works, "abcd") == {"d"}
    assert least(works, "abc") == {"b", "c"}
    assert least(works, "ab") is None
    assert least(lambda _: True, "ab") == frozenset()
    assert subsets({"x", "y"}) == [frozenset(), {"x"}, {"y"}, {"x", "y"}]


def test_robots_are_listed_with_their_package_its_version_and_licence(tiny: list[ZooRobot]) -> None:
    assert [robot.name for robot in tiny] == [
        "tiny_zoo.arm", "tiny_zoo.pair", "tiny_zoo.dropped", "tiny_zoo.broken", "no_such_zoo.away",
    ]  # fmt: skip
    assert {(robot.version, robot.licence) for robot in tiny[:4]} == {("1.5", "MIT")}
    assert (tiny[4].version, tiny[4].licence) == ("", "ISC")
    assert file_of(tiny[0]).name == "arm.urdf"
    with pytest.raises(NotHere, match="no-such-zoo is not installed"):
        file_of(tiny[4])
    assert [robot.name for robot in chosen(tiny, ["*.arm", "no_*"])] == ["tiny_zoo.arm", "no_such_zoo.away"]
    with pytest.raises(PlumblineError, match="names no robot of the zoo"):
        chosen(tiny, ["*.elephant"])


def test_a_robot_goes_in_with_the_least_left_out_for_each_engine_or_says_why_not(
    folder: Path, taken: dict[str, ZooEntry]
) -> None:
    stages = {name.partition(".")[2]: entry.stage for name, entry in taken.items()}
    assert stages == {"arm": "in", "pair": "in", "dropped": "in", "broken": "refused", "away": "not here"}
    assert taken["tiny_zoo.broken"].reason.startswith("broken.urdf: "), "where it is installed is nobody's business"
    arm, pair = taken["tiny_zoo.arm"], taken["tiny_zoo.pair"]
    assert (arm.scenario, arm.dropped, arm.bodies, arm.joints) == ("swing", (), 1, 1)
    assert {each.engine: each.drops for each in arm.engines} == dict.fromkeys(ENGINES, ())
    # dartpy binds no way to say whom a joint follows: DART alone needs that left out, which then all run without.
    assert {each.engine: each.drops for each in pair.engines} == {"dart": ("mimic",), "mujoco": (), "reference": ()}
    assert pair.dropped == ("mimic",)
    assert "coupling" in pair.engines[0].reason
    case = plugins.case(f"{plugins.SCENE_PREFIX}{folder / 'run' / pair.scene}")
    assert case.undropped is not None
    assert sum(joint.coupling is not None for joint in case.undropped.joints) == 1  # type: ignore[union-attr]
    assert taken["tiny_zoo.dropped"].scenario == "drop"


def test_a_folder_goes_on_from_what_it_knows_and_asks_again_for_what_was_not_here(
    folder: Path, tiny: list[ZooRobot], taken: dict[str, ZooEntry], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def again(_folder: Path, robot: ZooRobot, _engines: object, key: str) -> ZooEntry:
        asked.append(robot.name)
        return taken[robot.name]

    monkeypatch.setattr(zoo_intake, "take_in", again)
    assert {entry.name: entry for entry in taken_in(folder / "run", tiny, ENGINES, workers=1)} == taken
    assert asked == ["no_such_zoo.away"]
    asked.clear()
    taken_in(folder / "run", tiny, ("mujoco",), workers=1)
    assert len(asked) == len(tiny), "another set of engines is another question"


def test_a_publisher_that_could_not_be_reached_is_asked_once(
    folder: Path, tiny: list[ZooRobot], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def away(_folder: Path, robot: ZooRobot, _engines: object, key: str) -> ZooEntry:
        asked.append(robot.name)
        return ZooEntry(
            name=robot.name, title="", package=robot.package, version="", licence="", file="", key=key, reason="no road"
        )

    monkeypatch.setattr(zoo_intake, "take_in", away)
    monkeypatch.setattr(zoo_intake, "at_hand", lambda _: False)
    found = taken_in(folder / "unreached", tiny, ENGINES, workers=1)
    assert asked == ["tiny_zoo.arm", "no_such_zoo.away"]
    assert {(entry.stage, entry.reason) for entry in found} == {("not here", "no road")}


def test_an_entry_that_is_not_as_it_was_written_is_told(folder: Path, taken: dict[str, ZooEntry], tmp_path: Path) -> None:
    zoo_record.write(tmp_path, taken["tiny_zoo.pair"])
    assert list(zoo_record.entries(tmp_path)) == [taken["tiny_zoo.pair"]]
    path = tmp_path / "zoo" / "tiny_zoo.pair.json"
    path.rename(other := path.with_name("tiny_zoo.arm.json"))
    assert [where for where, _ in zoo_record.unsound(tmp_path)] == [other]
    with pytest.raises(DamagedFile):
        list(zoo_record.entries(tmp_path))


@pytest.fixture(scope="module")
def ran(folder: Path, tiny: list[ZooRobot], taken: dict[str, ZooEntry]) -> Store:
    """All of them; a step is said to cost 10 us."""
    del taken
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        clocked_by(patch, lambda _: [1e-5] * 3)
        adapters = {engine: plugins.adapter(engine) for engine in ENGINES}
        return carried_out(folder / "run", tiny, adapters, workers=1, resume=False, budget=900.0)


def test_the_table_has_a_row_a_robot_and_engine_and_one_for_who_does_not_go_in(ran: Store) -> None:
    table = tables.table("zoo")
    rows = {(row["robot"].partition(".")[2], row["engine"]): row for row in table.rows(ran)}
    assert set(rows) == {(name, engine) for name in ("arm", "pair", "dropped") for engine in ENGINES} | {
        ("broken", ""), ("away", ""),
    }  # fmt: skip
    for engine in ENGINES:
        assert rows["arm", engine]["verdict"] == "agrees"
        assert rows["arm", engine]["cost"] > 0
        assert rows["pair", engine]["dropped"] == "mimic"
    # A hand that follows its arm is bound to it; let go, it swings by itself: engines that have the coupling tell how far.
    assert rows["pair", "mujoco"]["omission"] > 0.02
    assert rows["pair", "dart"]["omission"] is None
    assert rows["broken", ""]["stage"] == "refused"
    words = table.said(ran)
    assert words[0] == "3 of 5 robots go in; 3 run on all of dart, mujoco, reference."
    assert words[-1] == "Of those that do not go in: refused 1, not here 1." or words[-1].endswith("not here 1, refused 1.")


def test_a_folder_without_a_zoo_has_no_rows_and_no_page(tmp_path: Path) -> None:
    assert list(zoo_record.entries(tmp_path)) == []


def test_the_page_shows_each_robot_with_its_picture_or_its_reason(ran: Store) -> None:
    assert PAGE in pages()
    assert PAGE.concerns(ran)
    files = PAGE.render(ran)
    page = str(files["zoo.html"])
    shown = page.partition('id="inside"')[2].partition('id="outside"')[0]
    assert len(re.findall('<img class="thumb"', shown)) >= 2, "shapes of a rod and of a ball"
    for title in ("A robot, arm.urdf", "A robot, pair.xml", "A robot, dropped.xml"):
        assert title in shown
    outside = page.partition('id="outside"')[2]
    assert "its files are refused" in outside
    assert "no-such-zoo is not installed" in outside
    assert "without mimic" in shown
    assert str(files["zoo.csv"]).startswith("robot,title,package,version,licence,stage,")


def test_robots_that_were_not_run_are_listed_apart_with_the_reason_and_counted(ran: Store) -> None:
    """What a folder says into which all robots were taken, and where the budget ended once the pair was run."""
    pairs = {*zip(ran.trials["experiment"], ran.trials["case"], strict=True)}
    (of_pair,) = {row["case"] for row in tables.table("zoo").rows(ran) if row["robot"] == "tiny_zoo.pair"}
    store = ran.part({(experiment, case) for experiment, case in pairs if case == of_pair})
    table = tables.table("zoo")
    rows = list(table.rows(store))
    assert list(dict.fromkeys(row["robot"].partition(".")[2] for row in rows)) == ["pair", "arm", "dropped", "away", "broken"]
    waiting = [row for row in rows if row["enters"] and not row["verdict"]]
    assert {(row["robot"], row["engine"]) for row in waiting} == {
        (f"tiny_zoo.{name}", engine) for name in ("arm", "dropped") for engine in ENGINES
    }  # fmt: skip
    assert {row["reason"] for row in waiting} == {NOT_RUN}
    assert table.said(store)[:2] == [
        "3 of 5 robots go in; 1 run on all of dart, mujoco, reference.",
        "Of those that go in, 2 were not run: the budget ended first, or the run was stopped; --resume goes on.",
    ]
    page = str(PAGE.render(store)["zoo.html"])
    shown, _, rest = page.partition('id="inside"')[2].partition('id="waiting"')
    apart = rest.partition('id="outside"')[0]
    assert "A robot, pair.xml" in shown
    assert "A robot, pair.xml" not in apart
    for title in ("A robot, arm.urdf", "A robot, dropped.xml"):
        assert title not in shown
        assert title in apart
    assert NOT_RUN in apart
    assert "were not run: 2" in apart
    assert 'id="waiting"' not in str(PAGE.render(ran)["zoo.html"])


def test_a_run_of_a_zoo_is_verified_with_its_entries(ran: Store) -> None:
    assert [problem.path for problem in problems(ran.folder) if "zoo" in problem.path.parts[-2:]] == []
    path = ran.folder / "zoo" / "tiny_zoo.arm.json"
    content = path.read_bytes()
    path.write_bytes(content.replace(b"tiny", b"Tiny", 1))
    try:
        assert path in [problem.path for problem in problems(ran.folder)]
    finally:
        path.write_bytes(content)


def test_a_zoo_goes_on_only_where_it_is_told_to(ran: Store, tiny: list[ZooRobot]) -> None:
    with pytest.raises(FolderTaken):
        carried_out(ran.folder, tiny, {}, workers=1, resume=False, budget=1.0)


def test_robots_go_a_few_at_a_time_so_that_what_is_broken_off_has_whole_robots() -> None:
    class Asked:
        def __init__(self, case: str) -> None:
            self.case = case

    guide = RobotByRobot(["a", "b", "c"], at_once=2, end=7.0)
    batches = list(guide.batches([Asked(case) for case in "cabcab"]))  # type: ignore[arg-type]
    assert [[trial.case for trial in batch] for batch in batches] == [["a", "b", "a", "b"], ["c", "c"]]
    assert guide.end() == 7.0
    assert guide.asked(["x", "y"], {"x": None}) == ["x", "y"]  # type: ignore[dict-item]
    guide.broken_off(())
    assert guide.asked(["x", "y"], {"x": None}) == ["x"]  # type: ignore[dict-item]


def test_without_its_packages_the_zoo_says_how_they_come(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PLUMBLINE_ENVIRONMENTS", str(tmp_path))
    monkeypatch.setattr("plumbline.harness.study.zoo.robots.version_of", lambda _: "")
    with pytest.raises(PlumblineError, match=r"--yes .* pip install 'plumbline\[zoo\]'"):
        zoo_robots((), agreed=False)


@pytest.mark.parametrize("more", [["--shard", "1/2"], ["--scheduler", "tcp://there:8786"]])
def test_a_zoo_is_run_on_this_machine_and_whole(more: list[str]) -> None:
    done = CliRunner().invoke(main, ["run", "zoo", *more])
    assert done.exit_code == 2
    assert "its robots lie on this machine" in done.output


def test_every_package_of_the_list_is_locked_and_the_extra_and_the_notice_name_those_that_install() -> None:
    listed = {robot.package for robot in robots(LIST)} | {MENAGERIE}
    locked = dict(re.findall(r"^([\w.-]+)==(\S+) \\\n +--hash=sha256:[0-9a-f]{64}$", zoo_intake.LOCK.read_text(), re.MULTILINE))
    assert set(locked) == listed
    extra = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]["zoo"]
    assert {line.partition(">")[0] for line in extra} <= listed
    notice = (ROOT / "NOTICE").read_text()
    for package in listed:
        assert package in notice
    licences = {robot.licence for robot in robots(LIST) if robot.package != MENAGERIE}
    assert {licence for licence in licences if licence not in notice} == set()


def test_no_robot_is_listed_whose_licence_forbids_what_a_report_does_with_it() -> None:
    """Pictures in a report are made from its meshes: no licence without derivatives, and none for some uses alone."""
    assert not [robot.name for robot in robots(LIST) if re.search(r"\b(NC|ND)\b", robot.licence)]
    assert len({robot.name for robot in robots(LIST)}) == len(robots(LIST))
    assert NAME not in json.dumps([robot.package for robot in robots(LIST)])
