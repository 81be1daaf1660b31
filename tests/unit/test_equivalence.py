"""Retellings: each says the same scene in other words and finds its way back; what an engine forgets or invents is seen."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.cases import system_determinism, system_far_origin, system_invariance, system_scale_length
from plumbline.harness.adapter import Diverged, Settings, Unsupported
from plumbline.harness.case import Case
from plumbline.harness.case.symmetries import Retelling, in_motion, moved, reordered, repeated, restored, scaled, turned
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.equivalence import AGREEING_SAMPLES, ATTITUDE_DIFFERENCE, DIFFERENCE, POSITION_DIFFERENCE
from plumbline.harness.props.regular_motions import stage
from plumbline.harness.scene import WORLD, Ball, Body, Revolute, Scene, Spring, axis_angle
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.trajectory import Contacts, Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import angle_between
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.equivalent_runs import equivalent_streams
from plumbline.harness.trial.simulate import simulate

DT, DURATION = 0.01, 0.5
Q = axis_angle((1.0, 2.0, 3.0), 0.7)
TELLINGS: dict[str, Callable[[Scene], Retelling]] = {
    "repeated": repeated,
    "restored": lambda scene: restored(scene, 0.2),
    "reordered": reordered,
    "moved": lambda scene: moved(scene, (3.0, -5.0, 2.0)),
    "turned": lambda scene: turned(scene, Q),
    "in_motion": lambda scene: in_motion(scene, (1.0, -2.0, 0.5)),
    "shrunk": lambda scene: scaled(scene, "shrunk", 1e-3),
    "grown": lambda scene: scaled(scene, "grown", 100.0),
}


class Thrown:
    """Every body flies by x0 + v0 t + g t^2/2 and turns at its own rate about its own axis: exactly the same in any words."""

    def __init__(self, scene: Scene, settings: Settings, fault: str = "") -> None:
        self._scene, self._dt, self._fault, self._step = scene, settings.dt, fault, 0

    @property
    def resolved(self) -> Settings:
        return Settings(dt=self._dt)

    def step(self, count: int = 1) -> None:
        self._step += count
        if self._fault == "diverges" and self._step > 20:
            raise Diverged("as planned")

    def state(self, out: State) -> None:
        t, start = self._step * self._dt, State.initial(self._scene)
        g = np.array(self._scene.gravity)
        free = np.array([[float(body.movable)] for body in self._scene.bodies])
        v_0 = start.v_WB.copy()
        if self._fault == "drag":
            v_0 *= np.exp(-0.01 * t)
        out.p_WB[:] = start.p_WB + v_0 * t + free * g * t**2 / 2
        if self._fault == "coarse":
            out.p_WB[:] = out.p_WB.astype(np.float32)
        if self._fault == "margin":
            out.p_WB[:] += 1e-4 * t
        if self._fault == "north":
            out.p_WB[:, 1] += 1e-3 * t
        if self._fault == "first":
            out.p_WB[0, 0] += 1e-12 * t
        out.v_WB[:], out.w_WB[:] = v_0 + free * g * t, start.w_WB
        angle = t * np.linalg.norm(start.w_WB, axis=1, keepdims=True)
        half = np.concatenate([np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) * start.w_WB * t / 2], axis=1)
        for k, (a, b) in enumerate(zip(half, start.q_WB, strict=True)):
            out.q_WB[k, 0] = a[0] * b[0] - a[1:] @ b[1:]
            out.q_WB[k, 1:] = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])

    def contacts(self) -> Contacts:
        return Contacts.none()

    def save(self) -> object:
        return self._step

    def restore(self, saved: Any) -> None:
        if self._fault == "refuses":
            raise Unsupported("restore", "as planned")
        self._step = saved + (1 if self._fault == "forgets" else 0)

    def warnings(self) -> tuple[str, ...]:
        return ()

    def close(self) -> None: ...


class Maker:
    """An adapter that makes thrown scenes with a planted fault; 'again' has it in every run but the first."""

    def __init__(self, fault: str = "") -> None:
        self._fault, self._made = fault, 0

    def build(self, scene: Scene, settings: Settings) -> Thrown:
        self._made += 1
        if self._fault == "again":
            return Thrown(scene, settings, "first" if self._made > 1 else "")
        return Thrown(scene, settings, self._fault)


def told(name: str, fault: str = "") -> tuple[Scene, Trajectory]:
    """The stage as it flies, with its retelling beside it."""
    scene, maker = stage(), Maker(fault)
    settings = Settings(dt=DT)
    plain = Thrown(scene, settings, "" if fault in ("diverges", "again") else fault)
    run, broke = simulate(
        plain,  # type: ignore[arg-type]
        scene, pace=Pace(DT), duration=DURATION, sample_interval=2 * DT, with_contacts=False, seed=0,
    )  # fmt: skip
    assert broke is None
    maker._made = 1
    streams, _ = equivalent_streams(TELLINGS[name](scene), maker, settings, DURATION, 2 * DT)  # type: ignore[arg-type]
    return scene, replace(run, streams=streams)


@pytest.mark.parametrize("name", TELLINGS)
def test_what_the_laws_do_not_tell_apart_comes_back_as_the_same_motion(name: str) -> None:
    scene, run = told(name)
    # Some tens of roundings of the largest place, 10 m away or in the moving frame.
    assert POSITION_DIFFERENCE[name](scene, run) < 1e-13
    assert ATTITUDE_DIFFERENCE[name](scene, run) < 1e-13
    if name in ("repeated", "restored", "reordered"):
        assert DIFFERENCE[name](scene, run) == 0.0
        assert AGREEING_SAMPLES[name](scene, run) == len(run.streams[f"{name}/time"])
    np.testing.assert_allclose(run.streams[f"{name}/v_WB"], run.v_WB[-len(run.streams[f"{name}/time"]) :], atol=1e-12)
    np.testing.assert_allclose(run.streams[f"{name}/w_WB"], run.w_WB[-len(run.streams[f"{name}/time"]) :], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "fault", "atleast"),
    [
        ("repeated", "again", 1e-13),
        ("restored", "forgets", 1e-2),
        ("in_motion", "drag", 1e-3),
        ("moved", "coarse", 1e-8),
        ("turned", "north", 1e-4),
        ("shrunk", "margin", 1e-3),
        ("grown", "margin", 1e-5),
    ],
)
def test_each_fault_is_seen_by_its_retelling(name: str, fault: str, atleast: float) -> None:
    scene, run = told(name, fault)
    assert max(DIFFERENCE[name](scene, run), POSITION_DIFFERENCE[name](scene, run)) > atleast
    assert AGREEING_SAMPLES[name](scene, run) < len(run)


def test_the_first_sample_that_differs_is_the_one_that_is_named() -> None:
    scene, run = told("repeated")
    other = run.streams["repeated/p_WB"].copy()
    other[7:, 2, 1] = np.nextafter(other[7:, 2, 1], np.inf)
    run = replace(run, streams=dict(run.streams) | {"repeated/p_WB": other})
    assert AGREEING_SAMPLES["repeated"](scene, run) == 7.0
    assert 0.0 < DIFFERENCE["repeated"](scene, run) < 1e-15
    other[3, 0, 0] = np.nan
    for metric in (
        m for kind in (DIFFERENCE, POSITION_DIFFERENCE, ATTITUDE_DIFFERENCE, AGREEING_SAMPLES) for m in kind.values()
    ):
        if metric.name.startswith("repeated") and "attitude" not in metric.name and "position" not in metric.name:
            assert np.isnan(metric(scene, run)), metric.name
    other[3, 2, 0] = np.inf
    assert not np.isfinite(POSITION_DIFFERENCE["repeated"](scene, run))


def test_a_retelling_that_diverges_is_never_close_and_one_that_is_refused_is_not_measured() -> None:
    scene, run = told("repeated", "diverges")
    assert np.isnan(DIFFERENCE["repeated"](scene, run))
    assert np.isnan(POSITION_DIFFERENCE["repeated"](scene, run))
    scene, run = told("restored", "refuses")
    with pytest.raises(NotMeasurable, match="no motion 'restored'"):
        DIFFERENCE["restored"](scene, run)


def test_a_restored_run_begins_where_it_was_saved() -> None:
    _, run = told("restored")
    time = run.streams["restored/time"]
    assert time[0] == pytest.approx(0.2)
    assert time[-1] == pytest.approx(DURATION)
    assert len(time) == 16


def test_what_cannot_be_told_is_refused_by_name() -> None:
    body = Body(name="a", p_WB=(1.0, 0.0, 0.0))
    hung = Scene(bodies=(body,), joints=(Ball(name="j", parent=WORLD, child="a", anchor_W=(0.0, 0.0, 0.0)),))
    with pytest.raises(ValueError, match="joint 'j': holds to the world"):
        in_motion(hung, (1.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="body 'a': is damped"):
        scaled(Scene(bodies=(replace(body, linear_damping=0.1),)), "grown", 10.0)
    hinge = stage().joints[0]
    assert isinstance(hinge, Revolute)
    sprung = replace(stage(), joints=(replace(hinge, spring=Spring(stiffness=1.0)),))
    with pytest.raises(ValueError, match="joint 'hinge': has a spring"):
        scaled(sprung, "grown", 10.0)


def test_a_scene_turned_there_and_back_is_the_scene() -> None:
    scene = stage()
    w, x, y, z = Q
    again = turned(turned(scene, Q).scene, (w, -x, -y, -z)).scene
    for one, other in zip(scene.bodies, again.bodies, strict=True):
        np.testing.assert_allclose(other.p_WB, one.p_WB, atol=1e-15)
        np.testing.assert_allclose(other.w_WB, one.w_WB, atol=1e-15)
        assert angle_between(np.array(one.q_WB), np.array(other.q_WB)) < 1e-15
    np.testing.assert_allclose(again.gravity, scene.gravity, atol=1e-14)
    np.testing.assert_allclose(again.joints[0].axis_W, scene.joints[0].axis_W, atol=1e-15)  # type: ignore[union-attr]


# --- the cases -------------------------------------------------------------------------------------


def _streams(run: Trajectory, name: str, shift: float = 0.0) -> dict[str, Floats]:
    parts = {part: getattr(run, part) for part in ("time", "p_WB", "q_WB", "v_WB", "w_WB")}
    parts["p_WB"] = parts["p_WB"] + shift
    return {f"{name}/{part}": value for part, value in parts.items()}


@pytest.mark.parametrize(
    ("case", "shift"),
    [
        (system_determinism.CASE, 1e-300),
        (system_invariance.CASE, 1e-6),
        # Twice the bound at this step.
        (system_far_origin.CASE, 2 * 3**0.5 * 16 * 101 * 2.0**-33 / 2),
        (system_scale_length.CASE, 1e-6),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_equal_motions_pass_and_one_a_little_aside_fails(case: Case, shift: float) -> None:
    scene = case.scene(case.parameters)
    names = [c.metric.name for c in case.checks if c.metric.name != "divergence"]
    tellings = [told.name for told in case.retellings(case.parameters)]  # type: ignore[misc]
    run = replace(Trajectory.of(np.arange(11) / 10, len(scene.bodies)), dt=DT)
    same = {key: value for name in tellings for key, value in _streams(run, name).items()}
    fine = replace(run, streams=same)
    assert all(c.passes(c.metric(scene, fine), DT, case.parameters) for c in case.checks)
    for name in names:
        telling = name.removesuffix("_position_difference").removesuffix("_difference")
        aside = replace(run, streams=same | _streams(run, telling, shift))
        check = next(c for c in case.checks if c.metric.name == name)
        assert not check.passes(check.metric(scene, aside), DT, case.parameters), name


def test_the_bodies_of_determinism_fall_free_of_each_other_at_first() -> None:
    scene = system_determinism.scene(system_determinism.P())
    places = np.array([body.p_WB for body in scene.bodies[1:]])
    # A box's corner is 0.142 m from its middle, a ball reaches 0.08: neighbours are a box and a ball.
    assert (np.linalg.norm(np.diff(places, axis=0), axis=1) > np.linalg.norm(system_determinism.HALF) - 0.005 + 0.08).all()
    assert places[0, 2] > np.linalg.norm(system_determinism.HALF)


def test_a_trial_runs_its_retellings_and_its_name_depends_on_them() -> None:
    case, adapter = system_far_origin.CASE, plugins.adapter("reference")
    study = Study(name="s", experiments=(Experiment(name="e", tracks=("tuned",), timing=False),))

    def name(of: Case) -> str:
        return next(iter(study.trials({of.name: of}, {adapter.name: adapter}, {adapter.name: "1"}))).trial

    elsewhere = replace(case, retellings=lambda _: (moved(stage(), (1.0, 0.0, 0.0)),))
    assert name(case) == name(replace(case))
    assert name(case) != name(elsewhere) != name(replace(case, retellings=None))
