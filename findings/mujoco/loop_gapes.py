# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0", "numpy"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "By default a closed loop gapes by half a millimetre and more, and finer steps do not help"
# seen = ["4.0.0"]
# documented = "Equality constraints are soft: solref's time constant, 0.02 s by default, does not shrink with the step."
# sources = ["MuJoCo, Modeling: solver parameters, solref"]
# mend = 'solref="2 dt 1" on the equality, two steps: the gap falls with the square of the step'
# cases = ["joint_fourbar"]
# cause = "soft loop joints, which gape"
# ///
"""Two cranks of 0.5 m and a coupler of 1 m, let go at 120 degrees, close a loop: a method of order p leaves (1/4)^p of the gap at a quarter of the step."""

import sys
import time

import mujoco
import numpy as np

CRANK = '<geom type="box" size=".02 .02 .25" pos="0 0 -.25" mass="1" contype="0" conaffinity="0"/>'
COUPLER = '<geom type="box" size=".5 .02 .02" pos=".5 0 0" mass="1" contype="0" conaffinity="0"/>'
STEPS = (1 / 240, 1 / 960, 1 / 3840)


def gap(mended, dt):
    """The greatest one within 2.5 s [m], and the time of the steps [s]."""
    solref = f'solref="{2 * dt!r} 1"' * mended
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt!r}" gravity="0 0 -9.81"/><worldbody>'
        f'<body pos="-.5 0 0" euler="0 -120 0"><joint axis="0 1 0"/>{CRANK}<body pos="0 0 -.5" euler="0 120 0"><joint axis="0 1 0"/>'
        f'<site name="a" pos="1 0 0"/>{COUPLER}</body></body>'
        f'<body pos=".5 0 0" euler="0 -120 0"><joint axis="0 1 0"/><site name="b" pos="0 0 -.5"/>{CRANK}</body>'
        f'</worldbody><equality><connect site1="a" site2="b" {solref}/></equality></mujoco>'
    )
    data, worst, took = mujoco.MjData(model), 0.0, 0.0
    for _ in range(round(2.5 / dt)):
        begun = time.process_time()
        mujoco.mj_step(model, data)
        took += time.process_time() - begun
        mujoco.mj_kinematics(model, data)
        worst = max(worst, float(np.linalg.norm(data.site("a").xpos - data.site("b").xpos)))
    return worst, took


def measure(mended):
    """The gaps [m] by step, and the time of the steps [s]."""
    runs = [gap(mended, dt) for dt in STEPS]
    return [worst for worst, _ in runs], sum(took for _, took in runs)


MENDED = "--mended" in sys.argv
gaps, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
# A method of first order would leave a quarter each time.
print(
    f"{'gone' if gaps[1] < gaps[0] / 2 and gaps[2] < gaps[1] / 2 else 'stands' if MENDED else 'still there'}: "
    f"{', '.join(f'{1e3 * worst:.4f}' for worst in gaps)} mm at 1/240, 1/960 and 1/3840 s"
)
