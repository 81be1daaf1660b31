# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0", "numpy"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "A closed loop gapes by half a millimetre however small the step"
# seen = ["4.0.0"]
# documented = "Equality constraints are soft: solref's time constant, 0.02 s by default, does not shrink with the step."
# sources = ["MuJoCo, Modeling: solver parameters, solref"]
# mend = 'solref with a time constant of a few steps on the equality: the gap falls by its square'
# cases = ["joint_fourbar"]
# cause = "soft loop joints, which gape"
# ///
"""Two cranks of 0.5 m and a coupler of 1 m, let go at 120 degrees: the greatest gap of the loop at 1/960 s and at a quarter of that."""

import mujoco
import numpy as np

CRANK = '<geom type="box" size=".02 .02 .25" pos="0 0 -.25" mass="1" contype="0" conaffinity="0"/>'
COUPLER = '<geom type="box" size=".5 .02 .02" pos=".5 0 0" mass="1" contype="0" conaffinity="0"/>'


def gap(dt):
    """The greatest one within 2.5 s [m]."""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt!r}" gravity="0 0 -9.81"/><worldbody>'
        f'<body pos="-.5 0 0" euler="0 -120 0"><joint axis="0 1 0"/>{CRANK}<body pos="0 0 -.5" euler="0 120 0"><joint axis="0 1 0"/>'
        f'<site name="a" pos="1 0 0"/>{COUPLER}</body></body>'
        f'<body pos=".5 0 0" euler="0 -120 0"><joint axis="0 1 0"/><site name="b" pos="0 0 -.5"/>{CRANK}</body>'
        '</worldbody><equality><connect site1="a" site2="b"/></equality></mujoco>'
    )
    data, worst = mujoco.MjData(model), 0.0
    for _ in range(round(2.5 / dt)):
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        worst = max(worst, float(np.linalg.norm(data.site("a").xpos - data.site("b").xpos)))
    return worst


coarse, fine = gap(1 / 960), gap(1 / 3840)
# A method of first order would leave a quarter.
print(f"{'gone' if fine < coarse / 2 else 'still there'}: {1e3 * coarse:.3f} mm at 1/960 s, {1e3 * fine:.3f} mm at 1/3840 s")
