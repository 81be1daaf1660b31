"""What a joint carries beside its constraint: the laws along its coordinate, by the names of their fields."""

from plumbline.harness.adapter.contract import Unsupported
from plumbline.harness.scene import Joint, Scene

LAWS = ("limits", "spring", "drive", "armature", "friction_loss", "speed_limit", "coupling")


def carried(joint: Joint) -> tuple[str, ...]:
    """The laws that a joint has; a rotor or a dry friction of 0 is none."""
    return tuple(name for name in LAWS if getattr(joint, name, None) not in (None, 0))


def followed(scene: Scene) -> frozenset[str]:
    """The names of the joints whose coordinates others are coupled to."""
    couplings = (getattr(joint, "coupling", None) for joint in scene.joints)
    return frozenset(coupling.joint for coupling in couplings if coupling is not None)


def refuse_tendons(scene: Scene) -> None:
    """For engines without tendons. Raises: Unsupported, where the scene has one."""
    for tendon in scene.tendons or ():
        joints = ", ".join(f"'{arm.joint}'" for arm in tendon.arms)
        raise Unsupported(f"tendon '{tendon.name}' of {joints}", "the adapter makes no force along several coordinates")


def refuse_armature(joint: Joint, why: str) -> None:
    """For engines without inertia along coordinates. Raises: Unsupported, where the joint has a rotor."""
    if "armature" in carried(joint):
        size = f"{joint.armature:g} {'kg m2' if joint.type == 'revolute' else 'kg'}"  # type: ignore[union-attr]
        raise Unsupported(f"joint '{joint.name}': armature of {size}", why)


def refuse_speed_limit(joint: Joint, why: str) -> None:
    """For engines without a bound of a coordinate's rate. Raises: Unsupported, where the joint has one."""
    if "speed_limit" in carried(joint):
        size = f"{joint.speed_limit:g} {'rad/s' if joint.type == 'revolute' else 'm/s'}"  # type: ignore[union-attr]
        raise Unsupported(f"joint '{joint.name}': speed limit of {size}", why)
