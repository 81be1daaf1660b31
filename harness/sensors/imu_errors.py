"""What an inertial channel does to a signal besides adding noise: a triad out of line, a scale error, bounds and digits.

The triad A of a channel stands turned against S by the rotation vector `misalignment`, so that it reads u_A = R_SA^T u_S; the
scale error multiplies what it reads. After the noise, readings are rounded to whole multiples of the quantisation, half a
step to the even one, and kept within the bounds: the greatest multiple that does not exceed the saturation.

Source: IEEE Std 952-1997 and IEEE Std 1293-2018 (misalignment, scale factor, full scale, resolution); Widrow, Kollar,
Quantization Noise (2008), section 1.1 (rounding to the nearest level).
"""

import numpy as np

from plumbline.harness.scene import AxisNoise
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import rotate_back


def sensed(law: AxisNoise, signal_S: Floats) -> Floats:
    """The signal (k, 3) as the channel's own triad and scale have it, before noise."""
    turn = np.array(law.misalignment)
    angle = float(np.linalg.norm(turn))
    scaled: Floats = (1.0 + law.scale_error) * signal_S
    if angle == 0.0:
        return scaled
    q_SA = np.array([np.cos(angle / 2), *(np.sin(angle / 2) / angle * turn)])
    return rotate_back(np.broadcast_to(q_SA, (len(scaled), 4)), scaled)


def read_out(law: AxisNoise, signal: Floats) -> Floats:
    """What comes out for a signal with its noise, in digits and within bounds; what is not a number stays none."""
    step, bound = law.quantisation, law.saturation
    if step > 0.0:
        signal = step * np.rint(signal / step)
        # A bound written as 16 g and a step of 16 g / 2^15 may miss each other by a rounding.
        bound = None if bound is None else step * np.floor(bound / step * (1.0 + 1e-12))
    return signal if bound is None else np.clip(signal, -bound, bound)
