# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0", "numpy"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "limit"
# title = "A free plate that turns by a tenth of a radian a step explodes under the default integrator"
# seen = ["4.0.0"]
# documented = "Euler is semi-implicit, with gyroscopic forces of the step's start; the implicit integrators and RK4 are recommended where these matter."
# sources = ["MuJoCo, Computation: numerical integration"]
# mend = 'integrator="RK4", or "implicit", which loses momentum instead'
# cases = ["spin_fast"]
# tracks = ["default"]
# cause = "a turn of a tenth of a radian a step under the default integrator"
# ///
"""Torque-free, its angular momentum stays: 100 rad/s about an axis between the principal ones, at 1/960 s, for two seconds."""

import mujoco
import numpy as np

SPEED = 100.0
MOMENTS = np.array([0.001, 0.002, 0.003])

model = mujoco.MjModel.from_xml_string(
    f'<mujoco><option timestep="{1 / 960!r}" gravity="0 0 0"><flag autoreset="disable"/></option><worldbody><body><freejoint/>'
    f'<inertial pos="0 0 0" mass="1" diaginertia="{" ".join(map(str, MOMENTS))}"/></body></worldbody></mujoco>'
)
data = mujoco.MjData(model)
data.qvel[3:] = SPEED * np.array([1.0, 1.0, 1.0]) / np.sqrt(3)
start, worst = float(np.linalg.norm(MOMENTS * data.qvel[3:])), 0.0
for _ in range(1920):
    mujoco.mj_step(model, data)
    now = float(np.linalg.norm(MOMENTS * data.qvel[3:]))
    worst = max(worst, abs(now / start - 1)) if np.isfinite(now) else float("inf")
    if not np.isfinite(now) or worst > 1e6:
        break
print(
    f"{'gone' if worst < 1 else 'still there'}: the angular momentum changes by a factor of {1 + worst:.3g} with no torque on the plate"
)
