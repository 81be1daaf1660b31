"""Is each law of an engine its own, or its adapter's, as the adapter tells it?

What an adapter does between the steps it must say: in each scene below the calls are watched that one step makes to the
vendor's package. An engine's own law needs none but the step; a call that hands over a force, a torque or a velocity is a law
of the adapter's. What is made once, in building, has tests of its own.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import FrameType
from typing import Any

import pytest

from plumbline.harness.adapter import Adapter, Advantage, Emulation, Feature, Settings, Simulation
from plumbline.harness.adapter.features import features_of
from plumbline.harness.conformance.checks.contract.features import _SCENES, _slide
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.findings.emulations import made, whose
from plumbline.harness.scene import Body, Drive, Effect, Limits, Scene, Spring
from tests.conformance.engines import NAMES, adapter, why_unavailable

UNEVEN = ((0.1, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.25))
STOPS, SPRING = Limits(lower=-1.0, upper=1.0), Spring(stiffness=10.0, damping=1.0)
DRIVE = Drive(stiffness=10.0, damping=1.0, target=0.5)

PLAIN: Mapping[Feature, Callable[[], Scene]] = {
    feature: _SCENES[feature]
    for feature in (
        Feature.KINEMATIC,
        Feature.BALL,
        Feature.REVOLUTE,
        Feature.PRISMATIC,
        Feature.DISTANCE,
        Feature.LIMITS,
        Feature.SPRINGS,
        Feature.DRIVES,
        Feature.STATIC_FRICTION,
        Feature.ROLLING_FRICTION,
        Feature.TORSIONAL_FRICTION,
        Feature.RESTITUTION,
        Feature.LINEAR_DAMPING,
        Feature.ANGULAR_DAMPING,
        Feature.CONTINUOUS_COLLISION,
    )
}
"""Scenes in which nothing is met that the words `where` of an adapter speak of."""
CONFINED: tuple[tuple[Feature, tuple[str, ...], Callable[[], Scene]], ...] = (
    (Feature.SPRINGS, ("limits",), lambda: _slide(limits=STOPS, spring=SPRING)),
    (Feature.DRIVES, ("limits",), lambda: _slide(limits=STOPS, drive=DRIVE)),
    (Feature.DRIVES, ("drive has a limit",), lambda: _slide(drive=Drive(stiffness=10.0, damping=1.0, target=0.5, limit=1.0))),
    (Feature.ANGULAR_DAMPING, ("uneven",), lambda: Scene(bodies=(Body(name="b", inertia=UNEVEN, angular_damping=0.5),))),
    (
        Feature.LINEAR_DAMPING,
        ("uneven",),
        lambda: Scene(bodies=(Body(name="b", inertia=UNEVEN, linear_damping=0.5, angular_damping=0.5),)),
    ),
)
"""Scenes that one of those words names, with the word."""
IN_BUILDING = {("mujoco", Feature.RESTITUTION), ("mujoco", Feature.KINEMATIC)}
"""What is made once, so that a step shows nothing of it."""
OWN = {("dart", "setCommands of a pace"), ("dart", "setErrorReductionParameter")}
"""The vendor's own actuator, which forgets its velocity after each step and is told it again; and a setting that all of its
worlds share, so that each has to set it while it steps."""


def handed_over(engine: Adapter, simulation: Simulation) -> set[str]:
    """The vendor's functions by which the adapter tells the engine something in one step."""
    simulation.step()
    called: set[str] = set()

    def watch(frame: FrameType, event: str, function: Any) -> None:
        if event == "c_call" and "adapters" in frame.f_code.co_filename:
            owner = getattr(function, "__self__", None)
            if engine.distribution in str(getattr(function, "__module__", None) or type(owner).__module__):
                of = "" if frame.f_code.co_filename.endswith("drives.py") else " of a pace"
                called.add(function.__name__ + (of if function.__name__ == "setCommands" else ""))

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        simulation.step()
    finally:
        sys.setprofile(before)
    told = {name for name in called if name.startswith(("set", "reset", "apply", "add", "change", "create"))}
    return {name for name in told if (engine.name, name) not in OWN}


def emulated(engine: Adapter, feature: Feature, track: str) -> list[Emulation]:
    return [one for one in engine.emulated if one.feature is feature and track in one.tracks]


@pytest.fixture(params=NAMES)
def engine(request: pytest.FixtureRequest) -> Adapter:
    if reason := why_unavailable(request.param):
        pytest.skip(reason)
    if request.param == "dart" and sys.version_info[:2] == (3, 12):
        pytest.skip("the profiler of Python 3.12 is not told of calls into dartpy, as those of 3.11 and 3.13 are")
    return adapter(request.param)


@pytest.mark.parametrize("track", ["default", "tuned"])
@pytest.mark.parametrize("feature", PLAIN, ids=lambda feature: feature.names[0])
def test_what_an_adapter_does_between_the_steps_is_told_and_nothing_else_is(
    engine: Adapter, feature: Feature, track: str
) -> None:
    if feature not in engine.features:
        pytest.skip("not claimed")
    with Engine(engine, engine.tracks[track]).built(PLAIN[feature](), dt=None) as simulation:
        acts = bool(handed_over(engine, simulation))
    told = [one for one in emulated(engine, feature, track) if not one.where and (engine.name, feature) not in IN_BUILDING]
    assert acts == bool(told)


@pytest.mark.parametrize("track", ["default", "tuned"])
@pytest.mark.parametrize(("feature", "words", "scene"), CONFINED)
def test_where_an_adapter_confines_what_it_makes_it_is_right_there_too(
    engine: Adapter, feature: Feature, words: tuple[str, ...], scene: Callable[[], Scene], track: str
) -> None:
    with Engine(engine, engine.tracks[track]).built(scene(), dt=None) as simulation:
        acts = bool(handed_over(engine, simulation))
    told = emulated(engine, feature, track)
    assert acts == any(not one.where or any(word in one.where for word in words) for one in told)


@pytest.mark.mujoco
def test_mujoco_has_no_coefficient_of_restitution_and_is_given_a_spring() -> None:
    mujoco = pytest.importorskip("mujoco")
    assert not [name for name in dir(mujoco.MjModel) if "restit" in name.lower() or "bounc" in name.lower()]
    engine = adapter("mujoco")
    with Engine(engine, engine.tracks["tuned"]).built(_SCENES[Feature.RESTITUTION](), dt=None) as simulation:
        # Negative: stiffness and damping told directly ("Modeling", solver parameters).
        assert (simulation._m.geom_solref.min(axis=0) < 0).all()  # type: ignore[attr-defined]


@pytest.mark.mujoco
def test_a_kinematic_body_of_mujoco_is_a_free_one_that_nothing_can_push() -> None:
    pytest.importorskip("mujoco")
    engine = adapter("mujoco")
    with Engine(engine, engine.tracks["tuned"]).built(_SCENES[Feature.KINEMATIC](), dt=None) as simulation:
        assert simulation._m.dof_armature.max() >= 1e12  # type: ignore[attr-defined]


def test_an_engine_tells_how_it_closes_a_loop_by_a_hinge(engine: Adapter) -> None:
    """The vendors' own constraints of a hinge are not used: each is two points, which is told."""
    with Engine(engine, engine.tracks["tuned"]).built(_SCENES[Feature.CLOSED_LOOP](), dt=None) as simulation:
        if engine.name == "mujoco":
            points = simulation._m.neq  # type: ignore[attr-defined]
        elif engine.name == "bullet":
            points = simulation._port.call("getNumConstraints")  # type: ignore[attr-defined]
        elif engine.name == "dart":
            points = len(simulation._built.loops)  # type: ignore[attr-defined]
        else:
            assert not emulated(engine, Feature.CLOSED_LOOP, "tuned")
            return
    assert points == 2
    assert emulated(engine, Feature.CLOSED_LOOP, "tuned")


@pytest.mark.parametrize("feature", [f for f in _SCENES if f is not Feature.PAIR_FRICTION], ids=lambda f: f.names[0])
def test_a_scene_says_which_features_it_uses(feature: Feature) -> None:
    scene = _SCENES[feature]()
    # A shape is one only where something can touch it, and an inertia is a matter of numbers.
    shapes = Feature.SPHERE | Feature.BOX | Feature.CAPSULE | Feature.CYLINDER | Feature.ELLIPSOID | Feature.PLANE
    shapes |= Feature.CONVEX_HULL | Feature.TRIANGLE_MESH | Feature.MOVING_MESH | Feature.FULL_INERTIA
    if feature not in shapes:
        assert feature in features_of(scene)
        assert feature not in features_of(replace(scene, narrow=scene.effects & ~Effect.CONTACT)) or feature in (
            Feature.KINEMATIC | Feature.PRESCRIBED_MOTION | Feature.COMPOUND | Feature.MASS_POINT | Feature.MASSLESS
        )
    elif feature is not Feature.FULL_INERTIA:
        assert feature in features_of(replace(scene, widen=Effect.CONTACT))


class Stub(Adapter):
    def version(self) -> str:
        return "1"

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        raise NotImplementedError


@pytest.mark.parametrize(
    "wrong",
    [
        Emulation(feature=Feature.DRIVES, how="a torque of the adapter"),
        Emulation(feature=Feature.SPRINGS, how=" "),
        Emulation(feature=Feature.SPRINGS, how="a torque of the adapter", tracks=("fast",)),
        Emulation(feature=Feature.SPRINGS | Feature.SPHERE, how="a torque of the adapter"),
    ],
    ids=["not claimed", "without how", "on no track", "two at once"],
)
def test_an_adapter_cannot_emulate_what_it_does_not_claim_nor_in_silence(wrong: Emulation) -> None:
    tracks = {"default": Settings(), "tuned": Settings()}
    claimed = Feature.SPRINGS | Feature.SPHERE
    with pytest.raises(ValueError, match="emulated"):
        Stub(name="stub", title="Stub", distribution="stub", features=claimed, tracks=tracks, emulated=(wrong,))


def test_a_finding_is_told_whose_law_it_is_about() -> None:
    told = [
        {"feature": "drives", "how": "a torque", "where": "", "tracks": ["tuned"]},
        {"feature": "springs", "how": "a torque", "where": "where limits can hold it", "tracks": ["default", "tuned"]},
    ]
    catalogue = {
        "engines": {"e": {"tracks": {"default": {}, "tuned": {}}, "emulated": told}, "f": {"tracks": {}, "emulated": []}},
        "cases": {"robot": {"features": ["drives", "springs"]}, "ball": {"features": ["sphere"]}},
    }
    assert whose(catalogue, "e", "robot", "tuned") == "drives, springs in part emulated"
    assert whose(catalogue, "e", "robot", "default") == "springs in part emulated"
    assert whose(catalogue, "e", "robot", "a variant of tuned") == whose(catalogue, "e", "robot", "tuned")
    assert whose(catalogue, "e", "ball", "tuned") == whose(catalogue, "f", "robot", "tuned") == ""
    assert [one.feature for one in made(catalogue, "e")] == ["drives", "springs"]
    assert made({}, "e", "robot") == []


def test_our_engine_gives_a_reason_only_for_cases_that_there_are() -> None:
    from plumbline.harness.study import plugins

    advantages = adapter("reference").advantages
    tracks, cases = adapter("reference").tracks, plugins.cases()
    assert advantages.keys() <= {f"{track}/{case}" for track in tracks for case in cases}
    assert all(isinstance(one, Advantage) and one.why.strip() for one in advantages.values())
