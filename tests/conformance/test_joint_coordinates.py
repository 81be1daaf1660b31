"""The reference engine keeps the contract in both choices of coordinates: every check of joints, on both tracks."""

from dataclasses import replace

import pytest

from adapters.reference import ADAPTER
from harness.adapter import Settings, Unsupported
from harness.conformance import CHECKS, run_check
from harness.study import plugins

CHOICE = {"default": "automatic", "tuned": "maximal"}
"""The coordinates that a track does not take by itself, where the engine knows both."""


def turned(track: str, settings: Settings) -> Settings:
    """The settings of a track with the other choice of coordinates."""
    return replace(settings, options={**settings.options, "coordinates": CHOICE[track]})


OTHER = replace(ADAPTER, tracks={name: turned(name, settings) for name, settings in ADAPTER.tracks.items()})
NAMES = tuple(
    check.name
    for check in CHECKS
    if "checks.joints." in check.run.__module__ or check.name == "prescribed_frame_leaves_behind_what_slides"
)
"""The checks whose scenes have joints."""


@pytest.mark.parametrize("track", OTHER.tracks)
@pytest.mark.parametrize("name", NAMES)
def test_a_check_of_joints_holds_in_the_other_coordinates(name: str, track: str) -> None:
    (check,) = (check for check in CHECKS if check.name == name)
    outcome = run_check(OTHER, track, check)
    assert outcome.status in ("passed", "not_applicable"), outcome.message


def test_checks_of_joints_are_solved_in_joint_coordinates_and_tell_so() -> None:
    scene = plugins.case("joint_chain").scene()
    for adapter, track in ((ADAPTER, "tuned"), (OTHER, "default")):
        resolved = adapter.build(scene, adapter.tracks[track]).resolved
        assert resolved.options["coordinates"] == "joint"
        assert adapter.build(scene, resolved).resolved == resolved
    for adapter, track in ((ADAPTER, "default"), (OTHER, "tuned")):
        assert "coordinates" not in adapter.build(scene, adapter.tracks[track]).resolved.options


def test_dry_friction_in_a_joint_is_taken_by_euler_in_the_bodies_own_coordinates() -> None:
    scene = plugins.case("joint_chain").scene()
    rough = replace(scene, joints=tuple(replace(joint, friction_loss=0.1) for joint in scene.joints))
    resolved = ADAPTER.build(rough, ADAPTER.tracks["tuned"]).resolved
    assert resolved.integrator == "semi_implicit_euler"
    assert "coordinates" not in resolved.options


def test_loops_and_contacts_keep_their_bodies_own_coordinates_or_are_refused_by_name() -> None:
    for name, reason in (("joint_fourbar", "closes a loop"), ("stand_quadruped", "contacts")):
        scene = plugins.case(name).scene()
        assert "coordinates" not in ADAPTER.build(scene, ADAPTER.tracks["tuned"]).resolved.options
        with pytest.raises(Unsupported, match=reason):
            ADAPTER.build(scene, replace(ADAPTER.tracks["tuned"], options={"coordinates": "joint"}))
