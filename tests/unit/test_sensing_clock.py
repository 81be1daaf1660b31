"""Sensors under the clock: how many steps, casts and readings one interval holds, counted; no time is asserted."""

from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.case import Clocks
from plumbline.harness.scene import Body, Imu, Lidar, Scene
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment, StudyError
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Hits, State
from plumbline.harness.trial.bench import Bench, bare_rays, sensed_interval, steps_of_interval

DT = 1 / 240


class Counting:
    """Counts the steps that are asked for, and the rays, which all meet body 0 two metres away."""

    def __init__(self) -> None:
        self.steps: list[int] = []
        self.rays: list[int] = []

    def step(self, count: int = 1) -> None:
        self.steps.append(count)

    def state(self, out: State) -> None:
        out.q_WB[:, 0] = 1.0

    def cast(self, origins: Any, directions: Any, max_range: float) -> Hits:
        self.rays.append(len(origins))
        return Hits(np.full(len(origins), 2.0), np.zeros(len(origins), dtype=np.int64), -directions)

    def close(self) -> None:
        """Nothing to free."""


class Maker:
    """An adapter of counting simulations."""

    def __init__(self) -> None:
        self.made: list[Counting] = []

    def build(self, scene: object, settings: object) -> Counting:
        self.made.append(Counting())
        return self.made[-1]


def bench(name: str, clocks: Clocks, **parameters: Any) -> tuple[Bench, Maker]:
    case, maker = plugins.case(name), Maker()
    trial = Trial(
        trial="t", study="s", experiment=Experiment(name="e"), case=name, parameters=dict(case.parameters) | parameters,
        engine="x", engine_version="1", track="tuned", settings=Settings(dt=DT), seed=0, clocks=clocks,
    )  # fmt: skip
    return Bench(case, maker, trial), maker  # type: ignore[arg-type]


def test_an_interval_holds_its_steps_and_one_scan() -> None:
    made, maker = bench("sensor_lidar_noise", "sensing", channels=4, columns=8)
    assert made.unit == "sensing"
    assert made.units == 1
    assert made.whole == 10  # a second at 10 Hz
    made.clock(3)
    assert sum(maker.made[0].steps) == 3 * 24
    assert maker.made[0].rays == [32] * 3


def test_bare_beams_are_cast_without_a_step_and_counted_one_by_one() -> None:
    made, maker = bench("sensor_lidar_noise", "casting", channels=4, columns=8)
    assert made.unit == "ray"
    assert made.units == 32
    made.clock(5)
    assert maker.made[0].rays == [32] * 5
    assert maker.made[0].steps == []


def sensors(*sensing: Any) -> Scene:
    return Scene(bodies=(Body(name="carrier", p_WB=(1.0, 2.0, 3.0)),), sensors=sensing)


def test_sensors_of_unlike_rates_share_the_interval_in_which_each_reads_whole_times() -> None:
    scene = sensors(Imu(name="imu", body="carrier", rate=80.0), Lidar(name="lidar", body="carrier", rate=60.0))
    assert steps_of_interval(scene, DT) == 12
    made = Counting()
    sensed_interval(scene, made, 0, DT)()  # type: ignore[arg-type]
    assert sum(made.steps) == 12
    assert len(made.rays) == 3


def test_bare_beams_start_where_the_sensor_stands() -> None:
    finder = Lidar(name="l", body="carrier", rate=10.0, channels=1, columns=4, elevation_low=0, elevation_high=0, max_range=7.0)
    rays = bare_rays(sensors(finder))
    assert rays.origins == pytest.approx(np.tile([1.0, 2.0, 3.0], (4, 1)))
    assert rays.directions == pytest.approx(np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]), abs=1e-15)
    assert rays.max_range == 7.0


def test_a_scene_without_sensors_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="no range finder"):
        bare_rays(sensors())
    with pytest.raises(ValueError, match="no sensor"):
        steps_of_interval(sensors(), DT)


@pytest.mark.parametrize(
    ("name", "clocks", "kind"), [("sensor_imu_noise", "casting", "range finder"), ("flight_box", "sensing", "sensor")]
)
def test_a_study_that_clocks_sensors_where_there_are_none_is_refused(name: str, clocks: Clocks, kind: str) -> None:
    study = Study(name="s", experiments=(Experiment(name="e", cases=(name,), clocks=(clocks,)),))
    with pytest.raises(StudyError, match=f"clocks '{clocks}' of case '{name}', which has no {kind}"):
        list(study.trials({name: plugins.case(name)}, {"mujoco": plugins.adapter("mujoco")}, {"mujoco": "1"}))
