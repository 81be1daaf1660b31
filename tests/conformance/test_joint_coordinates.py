"""The reference engine keeps the contract in joint coordinates, under every integrator, and in the bodies' own."""

from dataclasses import replace

import pytest

from plumbline.adapters.reference import ADAPTER
from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.conformance import CHECKS, run_check
from plumbline.harness.study import plugins
from plumbline.harness.study.foreseen_cost import scene_at


def in_coordinates(settings: Settings, coordinates: str, integrator: str | None = None) -> Settings:
    """These settings in other coordinates, by another integrator where one is named."""
    options = {**settings.options, "coordinates": coordinates}
    return replace(settings, options=options, integrator=integrator or settings.integrator)


OTHER = replace(ADAPTER, tracks={name: in_coordinates(settings, "automatic") for name, settings in ADAPTER.tracks.items()})
TREES_ALONE = Feature.COUPLING | Feature.MASSLESS | Feature.TENDON
"""What coordinates of trees alone know."""
OWN = replace(
    ADAPTER,
    features=ADAPTER.features & ~TREES_ALONE,
    known_failures={},
    tracks={name: in_coordinates(settings, "maximal") for name, settings in ADAPTER.tracks.items()},
)
F = Feature
LACKED = F.DISTANCE | F.DISTANCE_SPRING | F.CLOSED_LOOP | F.FRICTION_LOSS | F.SPEED_LIMIT | F.TENDON
"""What integrators of higher order have to refuse beside joints: what is no tree, and what is not smooth."""
MORE = replace(
    ADAPTER,
    features=ADAPTER.features & ~LACKED,
    tracks={
        name: in_coordinates(ADAPTER.tracks["tuned"], "automatic", name) for name in ("implicit_midpoint", "dormand_prince")
    },
    # Its limits act at the end of a step: a body at one is 2.1e-5 m/s off at 1 ms, and half of that at half the step.
    staggered=("implicit_midpoint",),
)
ALL = [(adapter, track) for adapter in (OTHER, OWN, MORE) for track in adapter.tracks]
NAMES = tuple(
    check.name
    for check in CHECKS
    if "checks.joints." in check.run.__module__ or check.name == "prescribed_frame_leaves_behind_what_slides"
)
"""The checks whose scenes have joints."""
TOUCHING = ("joined_bodies_do_not_collide", "joined_bodies_collide_when_told", "joint_reactions_beside_contacts")
"""Those in which bodies touch, which no tree does."""


SLOW = [(OTHER, "tuned"), (OWN, "tuned")]
"""What is the 'tuned' track as it is, which `test_conformance` asks too, and its integrator in the bodies' own coordinates."""


@pytest.mark.parametrize(
    ("adapter", "track"),
    [pytest.param(*both, marks=pytest.mark.slow if both in SLOW else ()) for both in ALL],
    ids=["euler", "rk4", "own_euler", "own_rk4", "midpoint", "adaptive"],
)
@pytest.mark.parametrize("name", NAMES)
def test_a_check_of_joints_holds_in_all_coordinates(name: str, adapter: Adapter, track: str) -> None:
    (check,) = (check for check in CHECKS if check.name == name)
    if adapter is MORE and name in TOUCHING:
        scene_with_contacts = scene_at(plugins.case("stand_quadruped"), {})
        with pytest.raises(Unsupported, match="contacts"):
            adapter.build(scene_with_contacts, adapter.tracks[track])
        return
    outcome = run_check(adapter, track, check)
    assert outcome.status in ("passed", "known", "not_applicable"), outcome.message


def test_checks_of_joints_are_solved_in_joint_coordinates_and_tell_so() -> None:
    scene = scene_at(plugins.case("joint_chain"), {})
    for track in ADAPTER.tracks:
        resolved = ADAPTER.build(scene, ADAPTER.tracks[track]).resolved
        assert resolved.options["coordinates"] == "joint"
        assert ADAPTER.build(scene, resolved).resolved == resolved
        assert "coordinates" not in OWN.build(scene, OWN.tracks[track]).resolved.options


def used(name: str, settings: Settings) -> Settings:
    """What the engine makes of the settings in a case's scene."""
    return ADAPTER.build(scene_at(plugins.case(name), {}), settings).resolved


def test_loops_keep_their_bodies_own_coordinates_unless_asked_for_under_semi_implicit_euler() -> None:
    for settings in ADAPTER.tracks.values():
        assert "coordinates" not in used("joint_fourbar", settings).options
    asked = replace(ADAPTER.tracks["default"], options={"coordinates": "joint"})
    assert used("joint_fourbar", asked).options["coordinates"] == "joint"
    with pytest.raises(Unsupported, match=r"joint '.*' under the integrator 'rk4'"):
        used("joint_fourbar", replace(ADAPTER.tracks["tuned"], options={"coordinates": "joint"}))


def test_trees_in_contact_take_joint_coordinates_under_semi_implicit_euler_unless_most_bodies_are_loose() -> None:
    for name, parts in (("default", (1, 4)), ("tuned", (1, 4))):
        settings = ADAPTER.tracks[name]
        told = used("stand_quadruped", settings)
        assert (told.options["coordinates"], told.integrator) == ("joint", "semi_implicit_euler")
        assert (told.substeps, told.iterations) == parts
        assert used("stand_quadruped", told) == told
        assert "coordinates" not in used("stand_quadruped", in_coordinates(settings, "maximal")).options
        assert "coordinates" not in used("system_far_origin", settings).options
    tuned = ADAPTER.tracks["tuned"]
    assert [used("stand_quadruped", replace(tuned, substeps=parts)).substeps for parts in (1, 2, 4, 16)] == [1, 1, 1, 2]
    scene = scene_at(plugins.case("stand_quadruped"), {})
    rubs = replace(scene, joints=tuple(replace(joint, friction_loss=0.01) for joint in scene.joints))
    assert ADAPTER.build(rubs, tuned).resolved.substeps == 1
    soft = replace(tuned, solver="tgs_soft")
    assert "coordinates" not in used("stand_quadruped", soft).options
    with pytest.raises(Unsupported, match="contacts under the integrator 'rk4'"):
        used("stand_quadruped", in_coordinates(soft, "joint"))
