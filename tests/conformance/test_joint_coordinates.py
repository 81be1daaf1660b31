"""The reference engine keeps the contract in joint coordinates as well: every check of joints, on both tracks."""

from dataclasses import replace

import pytest

from adapters.reference import ADAPTER
from harness.adapter import Settings, Unsupported
from harness.conformance import CHECKS, run_check
from harness.study import plugins


def in_joint_coordinates(settings: Settings) -> Settings:
    """These settings with joint coordinates, where the engine knows them."""
    return replace(settings, options={**settings.options, "coordinates": "automatic"})


OTHER = replace(ADAPTER, tracks={name: in_joint_coordinates(settings) for name, settings in ADAPTER.tracks.items()})
NAMES = tuple(
    check.name
    for check in CHECKS
    if "checks.joints." in check.run.__module__ or check.name == "prescribed_frame_leaves_behind_what_slides"
)
"""The checks whose scenes have joints."""


@pytest.mark.parametrize("track", OTHER.tracks)
@pytest.mark.parametrize("name", NAMES)
def test_a_check_of_joints_holds_in_joint_coordinates(name: str, track: str) -> None:
    (check,) = (check for check in CHECKS if check.name == name)
    outcome = run_check(OTHER, track, check)
    assert outcome.status in ("passed", "not_applicable"), outcome.message


def test_checks_of_joints_are_solved_in_joint_coordinates_and_tell_so() -> None:
    scene = plugins.case("joint_chain").scene()
    resolved = OTHER.build(scene, OTHER.tracks["tuned"]).resolved
    assert resolved.options["coordinates"] == "joint"
    assert OTHER.build(scene, resolved).resolved == resolved
    assert "coordinates" not in ADAPTER.build(scene, ADAPTER.tracks["tuned"]).resolved.options


def test_loops_and_contacts_keep_their_bodies_own_coordinates_or_are_refused_by_name() -> None:
    for name, reason in (("joint_fourbar", "closes a loop"), ("stand_quadruped", "contacts")):
        scene = plugins.case(name).scene()
        assert "coordinates" not in OTHER.build(scene, OTHER.tracks["tuned"]).resolved.options
        with pytest.raises(Unsupported, match=reason):
            ADAPTER.build(scene, replace(ADAPTER.tracks["tuned"], options={"coordinates": "joint"}))
