# /// script
# requires-python = ">=3.11"
# dependencies = ["dartpy==6.20.0"]
#
# [tool.finding]
# engine = "dart"
# kind = "bug"
# title = "MjcfParser makes a weld of <freejoint/>"
# seen = ["6.20.0"]
# documented = "MJCF: freejoint is a joint of type free. Written as <joint type='free'/> it is read as one."
# sources = ["MuJoCo, XML Reference: body/freejoint"]
# mend = '<joint type="free"/> in the file'
# cases = []
# ///
"""A ball that the file leaves free to move."""

import tempfile
from pathlib import Path

import dartpy

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "free.xml"
    path.write_text(
        '<mujoco><worldbody><body name="l" pos="0 0 1"><freejoint/><geom type="sphere" size="0.1" mass="3"/></body></worldbody></mujoco>'
    )
    world = dartpy.utils.MjcfParser.readWorld(str(path))
body = next(world.getSkeleton(k) for k in range(world.getNumSkeletons()) if world.getSkeleton(k).getName() == "l")
print(
    f"{'gone' if body.getNumDofs() == 6 else 'still there'}: a {body.getJoint(0).getType()} with {body.getNumDofs()} degrees of freedom, 6 are due"
)
