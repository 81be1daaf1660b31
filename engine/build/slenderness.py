"""Whether bodies that joints hold have moments of inertia near enough to each other for their inverse in floats."""

from collections.abc import Sequence

import numpy as np

from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import Joint
from plumbline.engine.maths.arrays import eigenvalues

SLENDEREST = 1e10
"""The largest ratio of a body's principal moments. In the world's axes each entry of the inverse inertia is rounded to 1e-16 of
the largest, about the thin axis: a rod of 1e10 (4 micrometres thick, a metre long) has six digits left across it, one of 1e14
none that SHAKE can use."""


def check_slenderness(bodies: Sequence[Body], joints: Sequence[Joint]) -> None:
    """Raises: NotSupported naming the first body, held by a joint, whose principal moments are further apart."""
    held = {name for joint in joints for name in (joint.parent, joint.child)}
    movable = [body for body in bodies if body.motion == "dynamic" and body.name in held]
    if not movable:
        return
    moments = np.array([eigenvalues(np.asarray(body.inertia, float)) for body in movable])
    slender = moments[:, 0] * SLENDEREST < moments[:, 2]
    if slender.any():
        k = int(slender.argmax())
        raise NotSupported(
            f"joints on body '{movable[k].name}'",
            f"its principal moments of inertia go from {moments[k, 0]:.3g} to {moments[k, 2]:.3g} kg m2, expected at "
            f"most {SLENDEREST:.0e} times as much",
        )
