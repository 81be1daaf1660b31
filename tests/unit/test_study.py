"""Studies: their files, and how they unfold into trials."""

import dataclasses
from pathlib import Path

import pytest

from harness import discover
from harness.study import Experiment, Study, StudyError, load_study


def test_every_built_in_study_is_readable() -> None:
    for path in (Path(discover.__file__).parent / "studies").glob("*.toml"):
        assert load_study(path.stem).name == path.stem


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name = 'x'", ("experiments", "Field required")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\ndt = [-1.0]", ("dt", "greater than 0", "-1.0")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\ntracks = ['fast']", ("tracks", "fast")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\nsample = 3", ("sample", "3")),
        ("name = = 'x'", ("not readable",)),
    ],
)
def test_a_broken_study_is_refused_naming_file_field_and_value(text: str, words: tuple[str, ...], tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(StudyError) as caught:
        load_study(str(path))
    for word in (str(path), *words):
        assert word in str(caught.value)


def test_an_unknown_study_is_answered_with_the_known_ones() -> None:
    with pytest.raises(StudyError, match=r"accuracy.*quick"):
        load_study("quikc")


def trial_names(study: Study, version: str = "1") -> list[str]:
    cases = {"flight_projectile": discover.case("flight_projectile")}
    adapters = {"mujoco": discover.adapter("mujoco")}
    return [trial.trial for trial in study.trials(cases, adapters, {"mujoco": version})]


def test_the_same_study_gives_the_same_trial_names_and_another_version_gives_others() -> None:
    study = load_study("accuracy")
    first = trial_names(study)
    assert len(first) == len(set(first)) == 2 * len(discover.case("flight_projectile").ladder)
    assert trial_names(study) == first
    assert not set(trial_names(study, version="2")) & set(first)


def test_all_combinations_of_parameters_are_run() -> None:
    experiment = Experiment(name="e", dt=(0.01,), tracks=("tuned",), parameters={"mass": (1.0, 2.0), "radius": (0.1, 0.2, 0.3)})
    cases = {"flight_projectile": discover.case("flight_projectile")}
    study = Study(name="s", experiments=(experiment,))
    trials = list(study.trials(cases, {"mujoco": discover.adapter("mujoco")}, {"mujoco": "1"}))
    assert {(t.parameters["mass"], t.parameters["radius"]) for t in trials} == {(m, r) for m in (1, 2) for r in (0.1, 0.2, 0.3)}
    assert len({t.trial for t in trials}) == len(trials) == 6
    assert all(t.parameters["velocity"] == cases["flight_projectile"].parameters["velocity"] for t in trials)


def test_a_parameter_that_a_case_does_not_have_is_named() -> None:
    study = Study(name="s", experiments=(Experiment(name="e", parameters={"colour": ("red",)}),))
    cases = {"flight_projectile": discover.case("flight_projectile")}
    with pytest.raises(StudyError, match=r"'flight_projectile' has no parameter 'colour'.*mass"):
        list(study.trials(cases, {"mujoco": discover.adapter("mujoco")}, {"mujoco": "1"}))


def test_another_scene_behind_the_same_parameters_is_another_trial() -> None:
    case = discover.case("flight_projectile")
    heavier = dataclasses.replace(case, scene=lambda **p: case.scene(**(p | {"mass": 2 * p["mass"]})))
    adapters, study = {"mujoco": discover.adapter("mujoco")}, load_study("quick")
    names = [{t.trial for t in study.trials({case.name: c}, adapters, {"mujoco": "1"})} for c in (case, heavier)]
    assert not names[0] & names[1]
