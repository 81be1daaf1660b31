"""The table and the page of many worlds on a run folder made by formula, and the case that it is made of."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.cases import system_worlds
from plumbline.harness.findings.tables.throughput import TABLE, Throughput, throughputs
from plumbline.harness.props.robots.arm import LOAD_MASS, grasping_arm
from plumbline.harness.scene import EARTH_GRAVITY, Prismatic, Revolute
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import Measurement, Record, StoredNotice, Timing
from plumbline.harness.store.store import Store, write_json
from plumbline.harness.trajectory import Trajectory
from tests.charts import checked
from tests.links import texts_of

G = 9.81
PRICE, EACH, ALONE = 2e-6, 5e4, 3e7
"""Seconds a step, bytes a world, bytes of the engine itself."""


def record(engine: str, kind: str, worlds: int, **fields: Any) -> Record:
    spread = fields.pop("spread", 0.0)
    plain = Record(
        trial=f"{engine}-{kind}-{worlds}",
        study="s",
        experiment="e",
        case="system_worlds",
        parameters={"kind": kind, "worlds": worlds},
        engine=engine,
        engine_version="1",
        track="default",
        dt=0.004,
        settings={},
        status="passed",
        reason="every check holds",
        trajectory_hash="same",
        memory=ALONE + EACH * worlds,
        measurements=(
            Measurement(metric="position_error_final", value=1e-4, unit="m"),
            Measurement(metric="world_spread", value=spread, unit="1"),
        ),
    )
    return replace(plain, **fields)


def timing(engine: str, kind: str, worlds: int) -> Timing:
    """A call costs as much as two steps of a world."""
    price = PRICE * (1 + 2 / worlds)
    return Timing(
        trial=f"{engine}-{kind}-{worlds}",
        unit="world-step",
        cpu_per_unit=price,
        cpu_per_unit_low=0.9 * price,
        cpu_per_unit_high=1.25 * price,
        unstable_timing=False,
    )


@pytest.fixture
def store(tmp_path: Path) -> Store:
    journal = Journal(tmp_path)
    for kind in ("box", "arm"):
        for worlds in (1, 16, 256):
            journal.append(record("even", kind, worlds))
            journal.append(timing("even", kind, worlds))
    short = StoredNotice("no room for all contacts", "capacity")
    journal.append(record("odd", "box", 1))
    journal.append(record("odd", "box", 16, spread=1e-9, trajectory_hash="other", warnings=(short,), status="failed"))
    journal.append(record("odd", "box", 256, status="oom", reason="out of memory", trajectory_hash=None, measurements=()))
    journal.close()
    case = {"parameters": {"kind": "box", "worlds": 1}, "headline": "position_error_final", "title": "Many worlds"}
    engines = {name: {"name": name, "title": name, "batch": name == "even"} for name in ("even", "odd")}
    write_json(tmp_path / "catalogue.json", {"cases": {"system_worlds": case}, "engines": engines})
    return Store(tmp_path)


def at(store: Store, engine: str, where: str, worlds: int) -> Throughput:
    (row,) = [row for row in throughputs(store) if (row.engine, row.where, row.worlds) == (engine, where, worlds)]
    return row


def test_a_rate_is_that_of_one_world_and_the_fastest_number_is_marked(store: Store) -> None:
    row = at(store, "even", "arm", 256)
    assert row.rate is not None
    assert row.rate.value == pytest.approx(1 / (PRICE * (1 + 2 / 256)))
    assert row.rate.low is not None
    assert row.rate.low < row.rate.value
    assert row.pace == pytest.approx(row.rate.value * 0.004)
    assert [each.worlds for each in throughputs(store) if each.best] == [256, 256]


def test_the_memory_of_a_world_is_what_each_further_one_takes(store: Store) -> None:
    assert at(store, "even", "box", 1).memory is None
    assert at(store, "even", "box", 256).memory == pytest.approx(EACH)


def test_bits_are_compared_by_place_and_by_size(store: Store) -> None:
    assert (at(store, "even", "box", 1).places, at(store, "even", "box", 1).sizes) == ("not known", "alike")
    assert (at(store, "even", "box", 16).places, at(store, "even", "box", 16).sizes) == ("alike", "alike")
    assert (at(store, "odd", "box", 16).places, at(store, "odd", "box", 16).sizes) == ("differ", "differ")
    assert at(store, "odd", "box", 256).sizes == "not known"


def test_what_an_engine_had_no_room_for_is_told(store: Store) -> None:
    assert at(store, "odd", "box", 16).short
    assert not at(store, "even", "box", 16).short


def test_the_page_has_every_row_and_two_charts_for_each_scene_that_was_clocked(store: Store) -> None:
    texts = texts_of(store, "throughput", "index")
    page = texts["throughput.html"]
    assert 'href="throughput.html"' in texts["index.html"]
    assert page.count("data-status=") == len(throughputs(store)) == 9
    assert "out of memory" in page
    assert {name for name in texts if name.startswith("charts/b")} == {
        f"charts/{kind}-{number}.svg" for kind in ("batching", "bought") for number in (0, 1)
    }
    assert checked([page]) > 0
    assert len(texts["throughput.csv"].splitlines()) == 10
    assert set(TABLE.rows(store)[0]) == set(TABLE.columns)


def test_a_store_with_one_number_of_worlds_has_no_such_page(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.append(record("even", "box", 1))
    journal.close()
    write_json(tmp_path / "catalogue.json", {"cases": {}, "engines": {}})
    assert "throughput.html" not in texts_of(Store(tmp_path), "throughput", "index")


# --- the case -------------------------------------------------------------------------------------


def test_the_box_falls_as_galileo_says_and_lies_where_it_fell() -> None:
    time = np.array([0.0, 0.02, 0.04, 0.1, 0.5])
    truth = system_worlds.expected(time, system_worlds.P())
    height = system_worlds.HALF + system_worlds.DROP
    assert truth.p_WB[:3, 1, 2] == pytest.approx(height - G * time[:3] ** 2 / 2)
    assert truth.p_WB[3:, 1, 2] == pytest.approx(system_worlds.HALF)
    assert truth.v_WB[3:] == pytest.approx(0.0)


def test_the_drives_of_the_arm_bear_what_a_lift_of_it_would_cost() -> None:
    """The torque of a hinge is the change of potential energy as all beyond it turns."""
    arm = grasping_arm(5.0, EARTH_GRAVITY, "load")
    hinges = [joint for joint in arm.joints if isinstance(joint, Revolute)]
    for first, joint in enumerate(hinges):
        assert joint.drive is not None

        def energy(angle: float, first: int = first, joint: Revolute = joint) -> float:
            c, s = math.cos(angle), math.sin(angle)
            total = 0.0
            for body in arm.bodies[first:]:
                x, _, z = np.subtract(body.p_WB, joint.anchor_W)
                total += body.mass * G * (c * z - s * x)  # turned about y
            return total

        torque = (energy(1e-4) - energy(-1e-4)) / 2e-4
        assert joint.drive.stiffness * joint.drive.target == pytest.approx(torque, rel=1e-6)


def test_each_finger_presses_towards_the_box() -> None:
    arm = grasping_arm(5.0, EARTH_GRAVITY, "load")
    bodies = {body.name: body for body in arm.bodies}
    for joint in arm.joints:
        if isinstance(joint, Prismatic):
            assert joint.drive is not None
            assert joint.drive.stiffness * joint.drive.target == pytest.approx(5.0)
            way = np.subtract(bodies["box"].p_WB, bodies[joint.child].p_WB)
            assert np.dot(way, joint.axis_W) > 0
    assert 2 * 0.8 * system_worlds.PRESS > 8 * LOAD_MASS * G


def verdicts(run: Trajectory, kind: str) -> dict[str, bool]:
    case = system_worlds.CASE
    p = case.at(kind=kind)
    truth = system_worlds.expected(run.time, p)
    return {c.metric.name: c.passes(c.metric(case.scene(p), run.between(c.start, 99.0), truth), run.dt, p) for c in case.checks}


@pytest.mark.parametrize("kind", system_worlds.KINDS)
def test_the_truth_passes_and_each_planted_fault_fails_its_check(kind: str) -> None:
    run = replace(system_worlds.expected(np.arange(11) / 20, system_worlds.P(kind=kind)), dt=1 / 240)
    run = replace(run, streams={"worlds/time": np.ones(1), "worlds/spread": np.zeros(1)})
    assert all(verdicts(run, kind).values())
    moved = run.p_WB.copy()
    moved[-1, -1, 0] += 3e-3
    fast = run.v_WB.copy()
    fast[-2:, -1, 0] += 0.1
    apart = {"worlds/time": np.ones(1), "worlds/spread": np.full(1, 1e-16)}
    for fault, check in (
        (replace(run, p_WB=moved), "position_error_final"),
        (replace(run, v_WB=fast), "rms_speed"),
        (replace(run, streams=apart), "world_spread"),
    ):
        assert not verdicts(fault, kind)[check]


def test_a_kind_that_there_is_not_is_named() -> None:
    with pytest.raises(ValueError, match="kind 'ball'"):
        system_worlds.scene(system_worlds.P(kind="ball"))
