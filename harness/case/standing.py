"""What a machine that stands on its drives is allowed: it falls for one step, and trembles less than it could feel.

The measure of a tremble is 0.01 g, the noise of a consumer accelerometer (300 micro-g/sqrt(Hz) over 1 kHz), over one step.
"""

from plumbline.harness.case import Check
from plumbline.harness.case.bounds import G
from plumbline.harness.metrics.conservation import held_energy_gain_max
from plumbline.harness.metrics.jitter import vibration_rms
from plumbline.harness.metrics.joints import pose_error_max
from plumbline.harness.metrics.slide import foot_slip
from plumbline.harness.metrics.stack import standing_height
from plumbline.harness.props.robots.floor import PRESSED

SHARE = 0.01
"""Of gravity, which a machine does not feel."""
GIVE = 1e-3
"""What a joint may be off under weight and still hold its pose [rad]."""


def stands_up() -> tuple[Check, ...]:
    """It stays up, and its drives give no energy."""
    return (
        Check(standing_height, 0.5, "the definition of a collapse: the top below half its height"),
        Check(
            held_energy_gain_max,
            lambda dt, _: (G * dt) ** 2 / 2 + G * PRESSED,
            "drives that hold a target take energy and give none; (g dt)^2/2 is what one step of gravity gives before "
            "the ground takes it away, and g times a micrometre what the ground gives back of the depth that feet begin at",
        ),
    )


def holds_its_pose(leg: float) -> Check:
    """Joints stay at their targets; `leg` [m] is the length of a leg's part."""
    return Check(
        pose_error_max,
        lambda dt, _: G * dt**2 / leg + GIVE,
        "before a contact can push, a machine falls for one step, g dt^2: so far a foot may give way, over the length "
        "of a leg's part; and a thousandth of a radian, a millimetre at a metre, which a contact may give way under weight",
    )


def still(leg: float) -> Check:
    """Joints do not tremble; `leg` [m] is the length of a leg's part."""
    return Check(
        vibration_rms,
        lambda dt, _: SHARE * G * dt / leg,
        "0.01 g, the noise of a consumer accelerometer (300 micro-g/sqrt(Hz) over 1 kHz), over one step, at the end "
        "of a leg's part: a machine that trembles less does not feel it",
    )


def feet_stay(start: float, duration: float) -> Check:
    """From `start` [s] to the end of the run no foot creeps away."""
    return Check(
        foot_slip,
        lambda dt, _: SHARE * G * dt * (duration - start),
        "the speed of 0.01 g over one step, kept up for the whole window",
        start=start,
    )
