# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "There is no coefficient of restitution, and by default a ball does not bounce"
# seen = ["4.0.0"]
# documented = "Restitution is got by springs: a damping ratio below 1 in solref, or its negative format, a stiffness and a damping, from which the rebound follows with contacts that last several steps."
# sources = ["MuJoCo, Modeling: restitution", "MuJoCo, Modeling: solver parameters, solref"]
# mend = 'solref="tc z" with z below 1, or solref="-stiffness -damping", with solimp near 1. Contacts cannot pull, so z sin and the rest follow from e = exp(-tan(p) (pi - 2 p)), z = sin p, and a contact of N steps from w = (pi - 2 p)/(cos p N dt), tc = 1/(w z); the textbook formula of a spring and damper is off'
# cases = ["impact_bounce", "impact_oblique"]
# ///
"""A ball of e 0.8 is dropped from a metre on a plane: 0.64 m are due. A spring's contact of ten steps is 20 ms, in which gravity takes part: 5 % of the height is granted."""

import math
import sys
import time

import mujoco

E, N, DT = 0.8, 10, 0.002


def spring():
    """The solref of a rebound of e in contacts of N steps, by bisection of the damping."""
    low, high = 0.0, math.pi / 2
    for _ in range(60):
        p = (low + high) / 2
        low, high = (p, high) if math.exp(-math.tan(p) * (math.pi - 2 * p)) > E else (low, p)
    return 1 / ((math.pi - 2 * p) / (math.cos(p) * N * DT) * math.sin(p)), math.sin(p)


def measure(mended):
    """How high the ball comes back [m], and the time of the steps [s]."""
    soft = 'solref="{!r} {!r}" solimp="0.9999 0.9999 0.001"'.format(*spring()) * mended
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{DT}"/><worldbody><geom type="plane" size="1 1 1" {soft}/><body pos="0 0 1.1"><freejoint/>'
        f'<geom type="sphere" size="0.1" {soft}/></body></worldbody></mujoco>'
    )
    data, touched, apex, begun = mujoco.MjData(model), False, 0.0, time.process_time()
    for _ in range(500):
        mujoco.mj_step(model, data)
        touched = touched or data.ncon > 0
        if touched and data.qvel[2] > 0:
            apex = max(apex, float(data.qpos[2]) - 0.1)
    return apex, time.process_time() - begun


SPEC = mujoco.MjSpec()
OWNERS = (SPEC, SPEC.option, SPEC.add_pair(), SPEC.worldbody.add_geom())
FIELDS = [name for owner in OWNERS for name in dir(owner) if "restitution" in name.lower()]


MENDED = "--mended" in sys.argv
apex, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if abs(apex / E**2 - 1) < 0.05 else 'stands' if MENDED else 'still there'}: "
    f"fields of a geom, a pair and the options named so: {', '.join(FIELDS) or 'none'}; dropped from 1 m a ball comes back to {apex:.3f} m, "
    f"{E**2:.2f} are due of e {E:g}"
)
