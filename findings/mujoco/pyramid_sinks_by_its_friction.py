# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "Under the default pyramidal cone a box at rest sinks the deeper, the larger its friction: 16 mm at mu 5"
# seen = ["4.0.0"]
# documented = "option/cone is pyramidal by default; its edges are soft springs whose regularisation grows with friction. That the depth at rest does is not said."
# sources = ["MuJoCo, XML Reference: option, cone", "MuJoCo, Computation: friction cones, constraint model"]
# mend = '<option cone="elliptic"/>'
# cases = []
# tracks = ["default"]
# ///
"""Boxes of mu 0.2 to 5 come to rest on a plane. How deep a weight presses a spring along the normal is no matter of friction: all alike, within a tenth."""

import sys
import time

import mujoco

FRICTIONS = (0.2, 0.5, 1.0, 2.0, 5.0)


def measure(mended, dt=1 / 240):
    """The depths [m] by friction, and the time of the steps [s]."""
    depths, took = [], 0.0
    for mu in FRICTIONS:
        model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{dt!r}" cone="{"elliptic" if mended else "pyramidal"}"/><worldbody>'
            f'<geom type="plane" size="9 9 1" friction="{mu} 0 0"/><body pos="0 0 0.1"><freejoint/>'
            f'<geom type="box" size="0.1 0.1 0.1" mass="1" friction="{mu} 0 0"/></body></worldbody></mujoco>'
        )
        data = mujoco.MjData(model)
        begun = time.process_time()
        mujoco.mj_step(model, data, round(3 / dt))
        took += time.process_time() - begun
        depths.append(0.1 - float(data.qpos[2]))
    return depths, took


MENDED = "--mended" in sys.argv
depths, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if max(depths) < 1.1 * min(depths) else 'stands' if MENDED else 'still there'}: "
    f"boxes of mu {', '.join(f'{mu:g}' for mu in FRICTIONS)} sink by {', '.join(f'{1e3 * depth:.3f}' for depth in depths)} mm, "
    f"at MuJoCo's own step by up to {1e3 * max(measure(MENDED, 0.002)[0]):.3f} mm"
)
