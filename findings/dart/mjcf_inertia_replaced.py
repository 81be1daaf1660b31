# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "MjcfParser replaces the inertia of a body by a unit tensor"
# seen = ["6.20.0"]
# documented = "MJCF: inertial/diaginertia is the inertia tensor of the body."
# sources = ["MuJoCo, XML Reference: body/inertial, diaginertia"]
# mend = "a URDF of the same robot"
# cases = []
# ///
"""A body of 2 kg and 0.1 kg m2 whose centre is 0.5 m from its hinge: 0.6 kg m2 about it."""

import tempfile
from pathlib import Path

import dartpy

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "inertia.xml"
    path.write_text(
        '<mujoco><worldbody><body name="l"><joint name="j" type="hinge" axis="0 1 0"/>'
        '<inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.1 0.1"/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
    )
    world = dartpy.utils.MjcfParser.readWorld(str(path))
body = next(world.getSkeleton(k) for k in range(world.getNumSkeletons()) if world.getSkeleton(k).getName() == "l")
about = float(body.getMassMatrix()[0, 0])
print(f"{'gone' if abs(about - 0.6) < 1e-6 else 'still there'}: {about:.3f} kg m2 about the hinge, 0.6 are due")
