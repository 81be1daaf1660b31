# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "By default a box creeps down an incline that holds it"
# seen = ["4.0.0"]
# documented = "Friction is soft: it lets bodies slip slowly. Against it the documentation has the elliptic cone with impratio above 1, and noslip iterations."
# sources = ["MuJoCo, Modeling: preventing slip", "MuJoCo, XML Reference: option, impratio, noslip_iterations"]
# mend = '<option cone="elliptic" impratio="100"/> (10 leaves 0.11 mm/s), or <option cone="elliptic" noslip_iterations="5"/>; noslip under the pyramidal cone does not help'
# cases = ["friction_creep", "friction_threshold", "stack_bowl"]
# cause = "soft friction, which creeps"
# ///
"""At 0.9 of the angle of friction Coulomb's law holds a box where it is; a tenth of a millimetre is what it settles by."""

import math
import sys
import time

import mujoco

G, MU = 9.81, 0.5
HARD, NOSLIP = 'cone="elliptic" impratio="100"', 'cone="elliptic" noslip_iterations="5"'


def creep(option, dt=1 / 240, share=0.9):
    """How far the box comes in a second [m], after half a second to settle; the time of the steps [s]."""
    angle = math.atan(share * MU)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt!r}" gravity="{G * math.sin(angle)!r} 0 {-G * math.cos(angle)!r}" {option}/><worldbody>'
        f'<geom type="plane" size="9 9 1" friction="{MU} 0 0"/><body pos="0 0 0.025"><freejoint/>'
        f'<geom type="box" size="0.1 0.1 0.025" mass="1" friction="{MU} 0 0"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(0.5 / dt))
    start, begun = float(data.qpos[0]), time.process_time()
    mujoco.mj_step(model, data, round(1 / dt))
    return float(data.qpos[0]) - start, time.process_time() - begun


def measure(mended):
    """The creep at 1/240 s and at MuJoCo's own step [m], and the time of the steps [s]."""
    (crept, took), (own, more) = creep(HARD * mended), creep(HARD * mended, 0.002)
    return crept, own, took + more


MENDED = "--mended" in sys.argv
crept, own, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(crept, own) < 1e-4 else 'stands' if MENDED else 'still there'}: "
    f"{1e3 * crept:.3f} mm in a second, {1e3 * own:.3f} at MuJoCo's own step; with five noslip iterations under the elliptic cone "
    f"{1e3 * creep(NOSLIP)[0]:.4f} mm; 0 is due"
)
