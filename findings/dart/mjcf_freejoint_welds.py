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
"""A ball that the file leaves free to move: six degrees of freedom."""

import sys
import tempfile
import time
from pathlib import Path

import dartpy


def measure(mended):
    """The joint's type, the degrees of freedom and the time of the loading [s]."""
    free = '<joint type="free"/>' if mended else "<freejoint/>"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "free.xml"
        path.write_text(
            f'<mujoco><worldbody><body name="l" pos="0 0 1">{free}<geom type="sphere" size="0.1" mass="3"/></body></worldbody></mujoco>'
        )
        begun = time.process_time()
        world = dartpy.utils.MjcfParser.readWorld(str(path))
        took = time.process_time() - begun
    body = next(world.getSkeleton(k) for k in range(world.getNumSkeletons()) if world.getSkeleton(k).getName() == "l")
    return body.getJoint(0).getType(), body.getNumDofs(), took


MENDED = "--mended" in sys.argv
joint, freedoms, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a loading")
print(
    f"{'gone' if freedoms == 6 else 'stands' if MENDED else 'still there'}: "
    f"a {joint} with {freedoms} degrees of freedom, 6 are due"
)
