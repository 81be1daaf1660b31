"""Which texts move a run: all that is at work while an engine steps, and none of what only judges."""

import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.case import Case, Problem
from plumbline.harness.case.alteration import Alteration
from plumbline.harness.case.forces import Control
from plumbline.harness.case.scene_file import own_case
from plumbline.harness.scene import Body, Imu, Lidar, PlacedShape, Plane, Scene, Sphere, Surface, sphere_inertia
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.study import plugins, provenance, sources
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial, question_of
from plumbline.harness.trial.answer import answer_of

ROOT = Path(sources.__file__).resolve().parents[2]
ROOMS = tuple(f"{ROOT / room}/" for room in ("adapters", "cases", "engine", "harness"))


def trial_of(case: Case, engine: str, alteration: Alteration) -> Trial:
    return Trial(
        study="s", experiment=Experiment(name="e"), case=case.name, parameters=dict(case.parameters), engine=engine,
        engine_version="", track="tuned", settings=plugins.adapter(engine).tracks["tuned"].with_dt(case.dt), seed=0,
        alteration=alteration,
    )  # fmt: skip


def at_work(case: Case, engine: str, alteration: Alteration) -> set[str]:
    """The files of ours of which code runs while an engine makes its answer, by their short names."""
    trial = trial_of(case, engine, alteration)
    problem, adapter = trial.problem(case), plugins.adapter(engine)
    seen: set[str] = set()

    def see(frame: Any, event: str, _: object) -> None:
        if event == "call":
            seen.add(frame.f_code.co_filename)

    before = sys.getprofile()
    sys.setprofile(see)
    try:
        answer_of(trial, problem, adapter)
    finally:
        sys.setprofile(before)
    return {
        path.relative_to(ROOT).as_posix() for path in (Path(name).resolve() for name in seen) if f"{path}".startswith(ROOMS)
    }


def moving(case: str, engine: str) -> set[str]:
    """The files behind the digests that a motion is named by."""
    origins = [name for name in provenance.sources_of(case, engine) if name in sources.MOVING and name != "libraries"]
    modules = frozenset().union(*(provenance._files_of_origin(origin, case, engine) for origin in origins))
    return set(sources.file_digests(modules))


def shortened(case: Case) -> Case:
    """The first steps of a case, a retelling or reading among them."""
    return replace(case, duration=min(case.duration, 0.2))


STEPPED = {
    "plain": ("flight_projectile", Alteration()),
    "a force from outside": ("orbit_kepler", Alteration()),
    "a turntable with an inertial unit": ("sensor_imu_turntable", Alteration()),
    "retellings": ("system_invariance", Alteration()),
    "contacts and impulses": ("stack_heavy_on_two", Alteration()),
    "many worlds": ("stack_pile", Alteration()),  # two of them
    "rays": ("system_rays", Alteration()),
    "another order": ("stack_tower", Alteration(name="again", told="reordered")),
    "a start of its own": ("stack_tower", Alteration(name="start", start=3)),
}


@pytest.mark.parametrize(("name", "alteration"), STEPPED.values(), ids=[*STEPPED])
@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_all_that_is_at_work_while_an_engine_steps_is_in_the_digest_of_its_motion(
    name: str, alteration: Alteration, engine: str
) -> None:
    case = shortened(plugins.case(name))
    if case.worlds:
        case = case.put({case.worlds: 2.0})
    seen = at_work(case, engine, alteration)
    assert {"harness/trial/answer.py", f"adapters/{engine}/__init__.py"} <= seen
    assert seen <= moving(name, engine), f"{seen - moving(name, engine)} move a run, and an edit of them would not run it anew"


def test_what_a_scene_of_ones_own_moves_and_senses_by_is_in_the_digest_of_its_motion(tmp_path: Path) -> None:
    ball = Body(
        name="ball", inertia=sphere_inertia(1.0, 0.1), collision=(PlacedShape(shape=Sphere(radius=0.1)),), p_WB=(0, 0, 0.3)
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    sensors = (Imu(name="unit", body="ball", rate=240.0), Lidar(name="finder", body="ball", rate=60.0, channels=2, columns=4))
    path = tmp_path / "ball.toml"
    path.write_text(dump_toml(Scene(bodies=(ground, ball), surfaces=(Surface(),), sensors=sensors)))
    case = shortened(own_case(path, plugins.SCENE_PREFIX))
    seen = at_work(case, "mujoco", Alteration())
    assert {"harness/trial/answer.py", "harness/sensors/recorder.py"} <= seen
    assert seen <= moving(case.name, "mujoco")


def test_what_only_judges_is_in_no_digest_of_a_motion() -> None:
    judging = {"harness/trial/truth_cache.py", "harness/trial/accuracy.py", "harness/case/case.py", "harness/metrics/errors.py"}
    for name in ("flight_projectile", "stack_tower"):
        files = moving(name, "mujoco")
        assert not judging & files
        assert not {file for file in files if file.startswith(("harness/metrics/", "harness/truths/", "cases/"))}


def code_in(value: Any) -> bool:
    """Is a value made of anything that runs?"""
    if is_dataclass(value) and not isinstance(value, type):
        return any(code_in(getattr(value, field.name)) for field in fields(value))
    if isinstance(value, list | tuple):
        return any(map(code_in, value))
    return callable(value)


def problems() -> Iterator[tuple[str, Problem]]:
    for name, case in plugins.cases().items():
        yield name, case.problem()


def test_a_case_whose_code_runs_while_an_engine_steps_says_so() -> None:
    acting = {name for name, problem in problems() if code_in(problem)}
    assert acting == {name for name in plugins.cases() if "acting" in provenance.sources_of(name, "mujoco")}
    assert 5 < len(acting) < 20  # most cases enter by value alone


def test_every_field_of_a_problem_is_in_the_digest_of_the_question() -> None:
    case = plugins.case("flight_projectile")
    plain = case.problem()
    others = {
        "scene": plugins.case("joint_pendulum").problem().scene, "duration": 0.5, "sample_interval": 0.5, "contacts": True,
        "impulses": True, "control": Control(targets=lambda _: {}), "worlds": 3, "readings_due": True,
        "rays": plugins.case("system_rays").problem().rays,
        "retellings": plugins.case("system_invariance").problem().retellings,
    }  # fmt: skip
    assert others.keys() == {field.name for field in fields(Problem)}
    told = [repr(replace(plain, **{name: value}).plain()) for name, value in others.items()]
    assert len({repr(plain.plain()), *told}) == 1 + len(others)
    assert question_of(case, {}, plain.scene) != question_of(replace(case, duration=0.5), {}, plain.scene)


def test_two_trials_that_differ_in_what_judges_alone_have_one_motion() -> None:
    texts = dict.fromkeys(("adapter", "stepping", "case", "harness", "truth", "libraries"), "same")
    first = replace(trial_of(plugins.case("flight_projectile"), "mujoco", Alteration()), sources=texts).named()
    for origin in texts:
        other = replace(first, sources=texts | {origin: "edited"}).named()
        assert other.trial != first.trial
        assert (other.motion != first.motion) == (origin in ("adapter", "stepping", "libraries")), origin


def test_a_package_that_hands_names_on_is_followed_to_those_that_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "handing"
    (package / "inner").mkdir(parents=True)
    (package / "__init__.py").write_text('"""Names."""\n\nfrom handing.inner import deep\nfrom handing.used import one\n')
    (package / "inner" / "__init__.py").write_text(
        "from handing.inner.deep import deep\nfrom handing.inner.aside import aside\n"
    )
    for name in ("used", "inner/deep", "inner/aside"):
        (package / f"{name}.py").write_text(f"{name.rpartition('/')[2]} = one = 1\n")
    askers = {
        "by_name": "from handing import one\n", "through_two": "from handing import deep\n", "whole": "import handing\n",
        "unknown": "from handing import other\n", "beside": "from handing.inner.aside import aside\n",
    }  # fmt: skip
    for name, text in askers.items():
        (package / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    reached = {name: {each.removeprefix("handing.") for each in sources.needed([f"handing.{name}"])} for name in askers}
    assert reached["by_name"] == {"by_name", "handing", "used"}
    assert reached["through_two"] == {"through_two", "handing", "inner", "inner.deep"}
    everything = {"handing", "used", "inner", "inner.deep", "inner.aside"}
    assert reached["whole"] == everything | {"whole"}
    assert reached["unknown"] == everything | {"unknown"}
    assert reached["beside"] == {"beside", "handing", "inner", "inner.aside"}
    (package / "__init__.py").write_text("from handing.used import one\nSETTING = one\n")
    for each in (sources._asked, sources.imported, sources._needed_by, sources._handed_on, sources._text):
        each.cache_clear()
    assert "used" in {each.removeprefix("handing.") for each in sources.needed(["handing.beside"])}  # it does something itself
