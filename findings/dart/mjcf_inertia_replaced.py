# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0", "numpy"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "MjcfParser replaces the inertia of a body by a unit tensor"
# seen = ["6.20.0"]
# documented = "MJCF: inertial/diaginertia is the inertia tensor of the body."
# sources = ["MuJoCo, XML Reference: body/inertial, diaginertia"]
# mend = "node.setInertia(Inertia(mass, centre, tensor)) for each body after loading, or a URDF of the same robot"
# cases = []
# ///
"""A body of 2 kg and 0.1 kg m2 whose centre is 0.5 m from its hinge: 0.6 kg m2 about it."""

import sys
import tempfile
import time
from pathlib import Path

import dartpy
import numpy as np


def measure(mended):
    """The inertia about the hinge [kg m2], and the time of the loading [s]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "inertia.xml"
        path.write_text(
            '<mujoco><worldbody><body name="l"><joint name="j" type="hinge" axis="0 1 0"/>'
            '<inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.1 0.1"/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
        )
        begun = time.process_time()
        world = dartpy.utils.MjcfParser.readWorld(str(path))
        body = next(world.getSkeleton(k) for k in range(world.getNumSkeletons()) if world.getSkeleton(k).getName() == "l")
        if mended:
            body.getBodyNode("l").setInertia(dartpy.dynamics.Inertia(2.0, np.array([0.5, 0.0, 0.0]), 0.1 * np.eye(3)))
        took = time.process_time() - begun
    return float(body.getMassMatrix()[0, 0]), took


MENDED = "--mended" in sys.argv
about, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a loading")
print(
    f"{'gone' if abs(about - 0.6) < 1e-6 else 'stands' if MENDED else 'still there'}: "
    f"{about:.3f} kg m2 about the hinge, 0.6 are due"
)
