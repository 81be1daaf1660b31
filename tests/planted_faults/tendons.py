"""The planted faults of fixed tendons."""

from dataclasses import replace

from plumbline.harness.adapter import Feature
from plumbline.harness.scene import Scene, Tendon
from tests.planted_faults.fault import fault

_NEEDS = Feature.REVOLUTE | Feature.PRISMATIC | Feature.TENDON
_BOTH = ("tendon_spring_pulls_by_its_arms", "tendon_drive_and_limits_hold")


def _each(scene: Scene, change: "object") -> Scene:
    return replace(scene, tendons=tuple(change(tendon) for tendon in scene.tendons or ()) or None)  # type: ignore[operator]


@fault(*_BOTH, needs=_NEEDS | Feature.DRIVES)
def tendon_dropped(scene: Scene) -> Scene:
    """tendons pull at nothing"""
    return replace(scene, tendons=None)


@fault(*_BOTH, needs=_NEEDS | Feature.DRIVES)
def tendon_without_arms(scene: Scene) -> Scene:
    """a tendon pulls at each joint alike, whatever its arm"""

    def alike(tendon: Tendon) -> Tendon:
        return replace(tendon, arms=tuple(replace(arm, arm=1.0) for arm in tendon.arms))

    return _each(scene, alike)


@fault("tendon_spring_pulls_by_its_arms", needs=_NEEDS)
def tendon_without_damper(scene: Scene) -> Scene:
    """the spring of a tendon has no damper"""
    return _each(scene, lambda tendon: replace(tendon, spring=tendon.spring and replace(tendon.spring, damping=0.0)))


@fault("tendon_spring_pulls_by_its_arms", needs=_NEEDS)
def tendon_without_rest(scene: Scene) -> Scene:
    """the spring of a tendon rests at a length of zero"""
    return _each(scene, lambda tendon: replace(tendon, spring=tendon.spring and replace(tendon.spring, rest=0.0)))


@fault("tendon_drive_and_limits_hold", needs=_NEEDS | Feature.DRIVES)
def tendon_drive_unlimited(scene: Scene) -> Scene:
    """the drive of a tendon is not cut off at its limit"""
    return _each(scene, lambda tendon: replace(tendon, drive=tendon.drive and replace(tendon.drive, limit=None)))


@fault("tendon_drive_and_limits_hold", needs=_NEEDS | Feature.DRIVES)
def tendon_without_limits(scene: Scene) -> Scene:
    """the length of a tendon has no bounds"""
    return _each(scene, lambda tendon: replace(tendon, limits=None))
