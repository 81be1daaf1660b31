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
"""Torque-free, its angular momentum stays: 50 to 200 rad/s about an axis between the principal ones, a tenth of a radian a step, for two thousand steps; MuJoCo's own 2 ms is among them."""

import sys
import time

import mujoco
import numpy as np

TURN = 0.1
SPEEDS = (50.0, 100.0, 200.0)
MOMENTS = np.array([0.001, 0.002, 0.003])


def spin(mended, speed):
    """By what factor the angular momentum changes [1], and the time of a step [s]."""
    integrator = "RK4" if mended else "Euler"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{TURN / speed!r}" gravity="0 0 0" integrator="{integrator}"><flag autoreset="disable"/></option>'
        f'<worldbody><body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{" ".join(map(str, MOMENTS))}"/></body>'
        "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qvel[3:] = speed * np.array([1.0, 1.0, 1.0]) / np.sqrt(3)
    start, worst, steps, begun = float(np.linalg.norm(MOMENTS * data.qvel[3:])), 0.0, 0, time.process_time()
    for _ in range(2000):
        steps += 1
        mujoco.mj_step(model, data)
        now = float(np.linalg.norm(MOMENTS * data.qvel[3:]))
        worst = max(worst, abs(now / start - 1)) if np.isfinite(now) else float("inf")
        if worst > 1e6:
            break
    return worst, (time.process_time() - begun) / steps


def measure(mended):
    """The factors [1] by speed, and the time of a step at each [s]."""
    runs = [spin(mended, speed) for speed in SPEEDS]
    return [worst for worst, _ in runs], sum(took for _, took in runs)


MENDED = "--mended" in sys.argv
factors, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(factors) < 1 else 'stands' if MENDED else 'still there'}: "
    f"the angular momentum changes by a factor of {', '.join(f'{1 + factor:.4g}' for factor in factors)} at "
    f"{', '.join(f'{speed:g}' for speed in SPEEDS)} rad/s with no torque on the plate"
)
