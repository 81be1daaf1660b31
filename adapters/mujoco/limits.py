"""The limits of a joint or tendon as a range of MuJoCo."""

from plumbline.adapters.mujoco.vendor import OPEN
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Joint, Limits, Tendon


def bounds_of(joint: Joint | Tendon) -> list[float] | None:
    """Both bounds of a joint's coordinate or a tendon's length, open ones beyond reach; None where it has none.

    Raises: Unsupported.
    """
    limits: Limits | None = getattr(joint, "limits", None)
    if limits is None or (limits.lower is None and limits.upper is None):
        return None
    lower = -OPEN if limits.lower is None else limits.lower
    upper = OPEN if limits.upper is None else limits.upper
    if lower >= upper:
        raise Unsupported(
            f"{'tendon' if isinstance(joint, Tendon) else 'joint'} '{joint.name}': limits {lower:g}..{upper:g} of no width",
            "MuJoCo's ranges have a width",
        )
    return [lower, upper]
