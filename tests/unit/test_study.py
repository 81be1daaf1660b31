"""Studies: their files, and how they unfold into trials."""

import dataclasses
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment, StudyError, Variant
from plumbline.harness.study.study import Study, call_roll, load_study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome


def test_every_built_in_study_is_readable() -> None:
    for path in (Path(plugins.__file__).parent / "built_in").glob("*.toml"):
        assert load_study(path.stem).name == path.stem


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name = 'x'", ("experiments", "Field required")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\ndt = [-1.0]", ("dt", "greater than or equal to", "-1.0")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\ntracks = ['fast']", ("tracks", "fast")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\nsample = 3", ("sample", "3")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\nclocks = ['thinking']", ("clocks", "thinking")),
        ("name = 'x'\n[[experiments]]\nname = 'e'\nworkers = [0]", ("workers", "0")),
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
    cases = {"flight_projectile": plugins.case("flight_projectile")}
    adapters = {"mujoco": plugins.adapter("mujoco")}
    return [trial.trial for trial in study.trials(cases, adapters, {"mujoco": version})]


def test_the_same_study_gives_the_same_trial_names_and_another_version_gives_others() -> None:
    study = load_study("accuracy")
    first = trial_names(study)
    assert len(first) == len(set(first)) == 2 * len(plugins.case("flight_projectile").ladder)
    assert trial_names(study) == first
    assert not set(trial_names(study, version="2")) & set(first)


def test_all_combinations_of_parameters_are_run() -> None:
    experiment = Experiment(name="e", dt=(0.01,), tracks=("tuned",), parameters={"mass": (1.0, 2.0), "radius": (0.1, 0.2, 0.3)})
    cases = {"flight_projectile": plugins.case("flight_projectile")}
    study = Study(name="s", experiments=(experiment,))
    trials = list(study.trials(cases, {"mujoco": plugins.adapter("mujoco")}, {"mujoco": "1"}))
    assert {(t.parameters["mass"], t.parameters["radius"]) for t in trials} == {(m, r) for m in (1, 2) for r in (0.1, 0.2, 0.3)}
    assert len({t.trial for t in trials}) == len(trials) == 6
    assert all(t.parameters["velocity"] == cases["flight_projectile"].parameters["velocity"] for t in trials)


def test_a_parameter_that_a_case_does_not_have_is_named() -> None:
    study = Study(name="s", experiments=(Experiment(name="e", parameters={"colour": ("red",)}),))
    cases = {"flight_projectile": plugins.case("flight_projectile")}
    with pytest.raises(StudyError, match=r"'flight_projectile' has no parameter 'colour'.*mass"):
        list(study.trials(cases, {"mujoco": plugins.adapter("mujoco")}, {"mujoco": "1"}))


def test_another_scene_behind_the_same_parameters_is_another_trial() -> None:
    case = plugins.case("flight_projectile")
    heavier = dataclasses.replace(case, scene=lambda p: case.scene(case.at(**dict(p) | {"mass": 2 * p["mass"]})))
    adapters, study = {"mujoco": plugins.adapter("mujoco")}, load_study("quick")
    names = [{t.trial for t in study.trials({case.name: c}, adapters, {"mujoco": "1"})} for c in (case, heavier)]
    assert not names[0] & names[1]


def test_what_is_clocked_and_by_how_many_are_trials_of_their_own_and_the_plain_one_keeps_its_name() -> None:
    cases, adapters = {"flight_box": plugins.case("flight_box")}, {"mujoco": plugins.adapter("mujoco")}

    def trials(**fields: object) -> list[Trial]:
        experiment = Experiment(name="e", tracks=("tuned",), **fields)  # type: ignore[arg-type]
        return list(Study(name="s", experiments=(experiment,)).trials(cases, adapters, {"mujoco": "1"}))

    (plain,) = trials()
    found = trials(clocks=("work", "reading", "call"), workers=(1, 2))
    assert [(t.clocks, t.workers) for t in found] == [
        ("work", 1), ("work", 2), ("reading", 1), ("reading", 2), ("call", 1), ("call", 2),
    ]  # fmt: skip
    assert len({t.trial for t in found}) == 6
    assert found[0].trial == plain.trial
    record = outcome(found[3], "passed", "")
    assert (record.clocks, record.workers) == ("reading", 2)


def test_rays_and_many_worlds_are_clocked_for_their_work_only() -> None:
    adapters = {"mujoco": plugins.adapter("mujoco")}
    for name, parameters in (("system_rays", {}), ("stack_pile", {"n": (4,), "worlds": (3,)})):
        study = Study(name="s", experiments=(Experiment(name="e", parameters=parameters, clocks=("reading",)),))
        with pytest.raises(StudyError, match=f"clocks 'reading' of case '{name}'.*expected 'work' alone"):
            list(study.trials({name: plugins.case(name)}, adapters, {"mujoco": "1"}))


VARIANTS = {"mujoco": {"cg": Variant(on="default", solver="cg"), "stiff": Variant(options={"contact_steps": 5.0})}}


def test_a_variant_runs_beside_the_tracks_under_its_own_name_and_settings() -> None:
    experiment = Experiment(name="e", dt=(0.01,), variants=("mujoco/*",))
    study = Study(name="s", variants=VARIANTS, experiments=(experiment,))
    engine = plugins.adapter("mujoco")
    cases = {"flight_projectile": plugins.case("flight_projectile")}
    trials = {t.track: t for t in study.trials(cases, {"mujoco": engine}, {"mujoco": "1"})}
    assert list(trials) == ["default", "tuned", "cg", "stiff"]
    assert trials["cg"].settings.solver == "cg"
    assert trials["cg"].settings.options == engine.tracks["default"].options
    assert trials["stiff"].settings.options == {**engine.tracks["tuned"].options, "contact_steps": 5.0}
    assert len({t.trial for t in trials.values()}) == 4


def test_variants_are_chosen_by_pattern_and_left_out_otherwise() -> None:
    cases, adapters = {"flight_projectile": plugins.case("flight_projectile")}, {"mujoco": plugins.adapter("mujoco")}
    for patterns, expected in (((), set()), (("mujoco/c*",), {"cg"}), (("bullet/*",), set()), (("*/stiff",), {"stiff"})):
        experiment = Experiment(name="e", tracks=(), variants=patterns)
        study = Study(name="s", variants=VARIANTS, experiments=(experiment,))
        assert {t.track for t in study.trials(cases, adapters, {"mujoco": "1"})} == expected


def test_a_variant_that_takes_a_tracks_name_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text("name = 'x'\n[variants.dart]\ntuned = {iterations = 3}\n[[experiments]]\nname = 'e'")
    with pytest.raises(StudyError, match="'dart/tuned': the name is a track's"):
        load_study(str(path))


def test_a_case_may_be_left_out_of_a_pattern() -> None:
    some = Experiment(name="e", cases=("stack_*",), without=("*_minutes",))
    assert [some.asks(name) for name in ("stack_tower", "stack_ten_minutes", "spin_fast")] == [True, False, False]


def test_the_quick_study_has_a_case_of_each_family_and_does_not_grow_by_itself() -> None:
    look = load_study("quick").experiments[0]
    assert "*" not in look.cases
    chosen = [name for name in plugins.names("cases") if any(fnmatchcase(name, pattern) for pattern in look.cases)]
    assert len(chosen) == 15


@pytest.mark.parametrize(
    ("given", "scene"),
    [
        ("scaling", "flight_box"),
        ("tremble", "stand_humanoid"),
        ("uneven_steps", "stack_tower"),
        ("level_of_detail", "system_level_of_detail"),
    ],
)
def test_every_variant_of_a_study_is_one_that_its_engine_builds(given: str, scene: str) -> None:
    study, case = load_study(given), plugins.case(scene)
    for name, variants in study.variants.items():
        engine = plugins.adapter(name)
        if plugins.version_of(engine)[1] is None:
            for variant in variants.values():
                engine.build(case.scene(case.parameters), variant.over(engine.tracks)).close()


def test_every_built_in_study_calls_whom_there_is() -> None:
    for path in (Path(plugins.__file__).parent / "built_in").glob("*.toml"):
        call_roll(load_study(path.stem), plugins.names("cases"), plugins.names("adapters"))
