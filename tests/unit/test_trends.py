"""Does a history tell each change once, at its night, of the group that it is of; and does what was seen stay seen?"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.findings.changes import Change
from plumbline.harness.history.folder import History
from plumbline.harness.history.identity import Named
from plumbline.harness.history.readings import NightOf
from plumbline.harness.history.regressions import FEWEST, Trends, date, read_trends
from plumbline.harness.history.retention import problems_of
from plumbline.harness.history.steps import CHANCE_OF_ALL, PriceStep, Series, price_steps, yardsticks
from plumbline.harness.store import store
from plumbline.harness.store.journal import Written, read_written
from plumbline.harness.store.record import Record, digest
from plumbline.harness.store.store import write_json
from plumbline.harness.trajectory import Floats
from tests.synthetic_history import write_history
from tests.synthetic_nights import NIGHTS, history

HISTORIES = 60
CELLS = [(engine, case, track) for engine in "abcd" for case in "xyz" for track in ("default", "tuned")]
"""Four engines, three cases, two tracks: twenty-four series, six an engine, two a case on an engine."""


def steps_of(
    seed: tuple[int, ...],
    changed: int = 1,
    factor: Floats | None = None,
    count: int = NIGHTS,
    chance: float = CHANCE_OF_ALL,
) -> list[PriceStep]:
    """What is told of a history of twenty-four series, of which the first `changed` are multiplied by `factor`.

    Args: count: of nights, the first so many. chance: of a history.
    """
    made = history(seed, series=len(CELLS), changed=changed, factor=factor)
    nights = replace(made, prices=made.prices[:, :count], canary=made.canary[:count])
    segments = np.zeros(count, np.int64)
    engines = [engine for engine, _, _ in CELLS]
    over = yardsticks(
        nights.prices,
        np.tile(segments, (len(CELLS), 1)),
        engines,
        np.tile(nights.canary, (len(CELLS), 1)),
        nights.canary,
        segments,
    )
    return list(price_steps([
        Series(
            kind="price", experiment="", case=case, where="", engine=engine, track=track, dt=0.01,
            metric="CPU time of a step", unit="s",
            values=values, over=factor, beside=beside, segments=segments, trials=("t",) * count, hashes=("",) * count,
        )
        for (engine, case, track), values, (factor, beside) in zip(CELLS, nights.prices, over, strict=True)
    ], chance))  # fmt: skip


def step(size: float, night: int) -> Floats:
    return np.where(np.arange(NIGHTS) >= night, 1 + size, 1.0)


def placed(size: float, changed: int) -> int:
    """Of sixty histories, how many tell one step of so many series, at its night or the one beside it."""
    count = 0
    for number in range(HISTORIES):
        night, signed = 8 + number * 44 // 59, size if number % 2 else -size
        told = [one for one in steps_of((12, number), changed, step(signed, night)) if one.change.engine == "a"]
        count += any(
            abs(one.night - night) <= 1 and (one.change.sense == "worse") == (signed > 0) and len(one.members) == changed
            for one in told
        )
    return count


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_sixty_whole_histories_without_a_change_tell_nothing() -> None:
    assert not [number for number in range(HISTORIES) if steps_of((11, number))]


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_of_a_thousand_unchanged_histories_fewer_than_one_in_a_hundred_says_a_word_in_one_of_its_nights() -> None:
    """Each is looked at in one night, drawn from the first that looks to the sixtieth, by the chance that this night has."""
    told = []
    for number in range(1000):
        count = FEWEST + number % (NIGHTS - FEWEST + 1)
        told += [number] * bool(steps_of((17, number), count=count, chance=CHANCE_OF_ALL / count))
    print(f"{len(told)} of 1000: {told}")
    assert len(told) < 10


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(("size", "changed", "least"), [(0.10, 2, 60), (0.10, 6, 60), (0.05, 2, 57), (0.05, 6, 57)])
def test_steps_of_a_case_and_of_an_engine_are_told_of_them_at_their_night(size: float, changed: int, least: int) -> None:
    assert placed(size, changed) >= least


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_drift_of_ten_percent_over_thirty_nights_is_told() -> None:
    for number in range(HISTORIES):
        drift = 1 + 0.1 * np.clip((np.arange(NIGHTS) - 5 - number % 20) / 30, 0, 1)
        told = steps_of((13, number), 2, drift)
        assert any(one.change.sense == "worse" and (one.change.engine, one.change.case) == ("a", "x") for one in told), number


def test_an_engine_that_steps_by_a_fifth_is_told_as_a_whole_and_makes_no_other_seem_faster() -> None:
    (told,) = steps_of((14, 0), 6, step(0.2, 30))
    assert (told.night, told.change.engine, told.change.case, told.change.count) == (30, "a", "", 6)
    assert told.change.low is not None
    assert told.change.high is not None
    assert told.change.low < 1.2 < told.change.high


def dearer(record: Record, times: float) -> Record:
    """The record with another price."""
    assert record.timing is not None
    return replace(record, timing=replace(record.timing, cpu_per_unit=times * (record.timing.cpu_per_unit or 0.0)))


def planted(night: int, record: Record) -> Record:
    """A dearer case at night 10, mended at 20; a larger error from night 5 on; a flip at 12 taken back at 15; a new version."""
    cell = record.engine, record.case
    if cell == ("dart", "friction_stop") and 10 <= night < 20:
        return dearer(record, 1.2)
    if cell == ("bullet", "joint_pendulum") and night >= 5:
        larger = (replace(record.measurements[0], value=3e-3),)
        return replace(record, trajectory_hash=digest(["other", record.track]), measurements=larger)
    if (*cell, record.track) == ("mujoco", "flight_projectile", "tuned") and 12 <= night < 15:
        return replace(record, status="failed", reason="too far", trajectory_hash="0123456789abcdef")
    if record.engine == "reference" and night >= 15:
        return replace(dearer(record, 0.8), engine_version="2.0")
    return record


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> History:
    return write_history(tmp_path_factory.mktemp("history") / "h", 28, planted)


@pytest.fixture(scope="module")
def trends(kept: History) -> Trends:
    return read_trends(kept)


def test_each_regression_is_told_once_first_bad_night_first_with_its_state(trends: Trends) -> None:
    told = [(one.night, one.first.kind, one.first.case, one.first.engine, one.state, one.until) for one in trends.regressions]
    assert told == [
        (5, "error", "joint_pendulum", "bullet", "open", None),
        (5, "error", "joint_pendulum", "bullet", "open", None),
        (10, "price", "friction_stop", "dart", "mended", 20),
        (12, "verdict", "flight_projectile", "mujoco", "mended", 15),
    ]
    price = trends.regressions[2].first
    # Two medians of ten nights of two prices with 2 % noise each: 2 % / sqrt(20) each, three spreads of their difference.
    assert price.ratio == pytest.approx(1.2, rel=3 * 0.02 / 10**0.5 / 2**0.5 * 2**0.5)
    assert trends.regressions[0].command.startswith(f"plumbline reproduce {trends.regressions[0].folder} ")


def test_another_version_opens_a_segment_and_is_no_change_of_price(trends: Trends) -> None:
    mine = [one for one in trends.series if one.engine == "reference" and one.kind == "price"]
    assert all(len(set(one.segments)) == 2 for one in mine)
    assert not [one for one in trends.dated if one.first.engine == "reference"]


def test_a_price_has_the_name_under_which_a_night_told_it_and_one_word_silences_it() -> None:
    nights = [
        NightOf(stamp=f"202609{day:02}T000000Z", folder="", machine="m", processor="", versions={"a": "1"})
        for day in range(1, 20)
    ]
    stepped = Change(kind="price", sense="worse", case="x", engine="a", metric="CPU time", ratio=1.2, count=2)
    one_track = replace(stepped, track="tuned", dt=0.01, metric="CPU time of a step", count=1)
    whole = replace(stepped, case="")
    told = Named.of(one_track, nights[9].stamp)
    (seen,) = date(nights, [PriceStep(8, stepped)], {}, [told])
    assert (seen.id, seen.told, seen.state) == (told.id, True, "open")
    for named, changes, state in (
        (told, (stepped,), "acknowledged"),
        (Named.of(whole, nights[9].stamp), (stepped, whole), "acknowledged"),
        (told, (whole,), "open"),
        (replace(told, sense="better"), (replace(stepped, case="y"),), "open"),
    ):
        entry = replace(named, note="known")
        assert {row.state for row in date(nights, [PriceStep(8, change) for change in changes], {named.id: entry}, [told])} == {
            state
        }
    (apart,) = date(nights, [PriceStep(14, stepped)], {told.id: replace(told, note="known")}, [told])
    assert (apart.told, apart.state) == (False, "open")


def test_what_was_acknowledged_keeps_its_note_and_stands_no_more(kept: History, trends: Trends) -> None:
    name = trends.standing()[0].id
    run = CliRunner()
    for text, code in ((name[:6], 0), ("nothing", 2)):
        done = run.invoke(main, ["history", "ack", text, "--note", "known: #12", "--history", str(kept.root)])
        assert done.exit_code == code, done.output
    again = read_trends(kept)
    assert [one.id for one in again.standing()] == [one.id for one in trends.standing() if one.id != name]
    (seen,) = [one for one in again.regressions if one.state == "acknowledged"]
    assert (seen.id, seen.note) == (name, "known: #12")
    page = run.invoke(main, ["report", str(kept.root)])
    assert page.exit_code == 0, page.output
    text = (kept.root / "report" / "index.html").read_text()
    assert "known: #12" in text
    titles = trends.titles
    assert text.index("acknowledged</span>") < text.index(f"{titles['friction_stop']} on {titles['dart']}")
    prose = re.sub(r"(?s)<(code|script|style)\b.*?</\1>|<[^>]*>", " ", text)
    assert [name for name in titles if re.search(rf"(?<!Plumbline )\b{name}\b", prose)] == []


def test_a_night_that_is_over_is_read_once_and_again_where_its_files_are_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    history = write_history(tmp_path / "h", 3, planted)
    read: list[str] = []

    def written(path: Path) -> Written:
        read.append(path.parent.name)
        return read_written(path)

    monkeypatch.setattr(store, "read_written", written)
    stamps = [night.stamp for night in history.nights()]
    first = read_trends(history)
    assert read == stamps
    again = read_trends(history)
    assert read == stamps
    assert (again.nights, again.dated) == (first.nights, first.dated)
    for one, other in zip(first.series, again.series, strict=True):
        assert (one.kind, one.case, one.trials, one.hashes) == (other.kind, other.case, other.trials, other.hashes)
        np.testing.assert_array_equal(one.free, other.free)
    write_json(history.nights()[1].folder / "machine.json", {"processor": "another"})
    damaged = history.root / "readings" / f"{stamps[2]}.json"
    damaged.write_bytes(damaged.read_bytes().replace(b"joint_pendulum", b"joint_pendulam"))
    assert [night.processor for night in read_trends(history).nights] == ["A", "another", "A"]
    assert read == [*stamps, *stamps[1:]]
    assert [problem for problem in problems_of(history) if problem.path.parent.name in ("h", "readings")] == []
