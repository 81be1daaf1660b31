"""The limits of a joint as a range of MuJoCo."""

from plumbline.adapters.mujoco.vendor import OPEN
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Joint, Limits


def bounds_of(joint: Joint) -> list[float] | None:
    """Both bounds of a joint's coordinate, open ones beyond reach; None where it has none. Raises: Unsupported."""
    limits: Limits | None = getattr(joint, "limits", None)
    if limits is None or (limits.lower is None and limits.upper is None):
        return None
    lower = -OPEN if limits.lower is None else limits.lower
    upper = OPEN if limits.upper is None else limits.upper
    if lower >= upper:
        raise Unsupported(f"joint '{joint.name}': limits {lower:g}..{upper:g} of no width", "MuJoCo's ranges have a width")
    return [lower, upper]
