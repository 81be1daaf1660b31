"""If an adapter says that a knob means nothing in a scene, or resolves a turned one to the settings that it has anyway, every
bit of the answer stays as it was."""

from dataclasses import replace

import pytest

from plumbline.harness.adapter import Settings, SettingsError, Unsupported
from plumbline.harness.scene import Scene
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.one_knob import turned
from plumbline.harness.study.study import Study
from plumbline.harness.trajectory import State
from plumbline.harness.trial.beside_tuned import idle_turns
from tests.conformance.engines import NAMES, adapter, why_unavailable

SCENES = {
    "flight_box": "nothing acts on nothing",
    "spin_heavy_top": "a joint and no contact",
    "joint_spring": "a spring",
    "joint_limits": "a stop",
    "joint_fourbar": "a loop",
    "rest_penetration": "contact",
    "friction_stop": "friction",
    "impact_bounce": "rebounds",
    "stand_quadruped": "drives",
}
"""Cases, and what acts there."""
STEPS = 30


def answer(engine: str, scene: Scene, settings: Settings) -> bytes:
    """The state after some steps; nothing where the settings are refused."""
    try:
        simulation = adapter(engine).build(scene, settings)
    except (SettingsError, Unsupported):
        return b""
    out = State.initial(scene)
    simulation.step(STEPS)
    simulation.state(out)
    simulation.close()
    return b"".join(getattr(out, name).tobytes() for name in ("p_WB", "q_WB", "v_WB", "w_WB"))


@pytest.mark.parametrize("engine", NAMES)
@pytest.mark.parametrize("case", SCENES)
def test_a_knob_that_acts_on_nothing_here_changes_nothing(case: str, engine: str) -> None:
    if why_unavailable(engine):
        pytest.skip(why_unavailable(engine))
    question, contestant = plugins.case(case), adapter(engine)
    scene = question.scene(question.parameters)
    track = replace(contestant.tracks["tuned"], dt=question.dt)
    base = answer(engine, scene, track)
    if not base:
        pytest.skip(f"{engine} does not know {case}")
    meant = contestant.knobs_in(scene)
    idle = [(knob, value) for knob, values in contestant.knobs.items() if knob not in meant for value in values]
    felt = [(knob, value) for knob, value in idle if answer(engine, scene, turned(track, knob, value)) not in (base, b"")]
    assert felt == []


@pytest.mark.parametrize("engine", NAMES)
@pytest.mark.parametrize("case", SCENES)
def test_a_turn_that_resolves_to_the_same_settings_changes_nothing(case: str, engine: str) -> None:
    """Searches leave such turns out."""
    if why_unavailable(engine):
        pytest.skip(why_unavailable(engine))
    question, contestant = plugins.case(case), adapter(engine)
    study = Study(name="s", experiments=(Experiment(name="e", tracks=("tuned",)),))
    (trial,) = study.trials({case: question}, {engine: contestant}, {engine: "1"})
    scene = question.scene(question.at(**trial.parameters))
    base = answer(engine, scene, trial.settings)
    idle = idle_turns(trial, question, contestant)
    assert bool(idle) == bool(base), "every engine takes one sub-step for none, or has a solver chosen"
    assert [turn for turn in idle if answer(engine, scene, turned(trial.settings, *turn)) != base] == []
