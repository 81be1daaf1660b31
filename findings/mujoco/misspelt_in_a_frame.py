# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "A misspelt attribute within a frame is read as nothing"
# seen = ["4.0.0"]
# documented = "MJCF is said to be checked against a schema, which names what is unknown; frame and replicate are said to lie outside of it. That what they hold is not checked either is not said."
# sources = ["MuJoCo, XML Reference: meta elements", "MuJoCo, Modeling: URDF extensions"]
# mend = "load the file a first time with its frames renamed to bodies, to have it checked, or compare the attributes with those of mj_printSchema"
# cases = []
# ///
"""A hinge's damping of 0.5 N m s/rad, misspelt: refused in a body, and in the same body within a frame read as a hinge without damping."""

import re
import sys
import time

import mujoco

BODY = '<body><joint dampng="0.5"/><geom size="0.1"/></body>'
SOUND = BODY.replace("dampng", "damping")


def read(inside):
    """The model; None if it is refused."""
    try:
        return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{inside}</worldbody></mujoco>")
    except ValueError:
        return None


def read_checked(body, mended):
    """The model of a body within a frame; None if it is refused. Mended, the file is read a first time with the frame as a body."""
    framed = f"<frame>{body}</frame>"
    return None if mended and read(re.sub(r"\bframe\b", "body", framed)) is None else read(framed)


def measure(mended):
    """The model of a misspelt hinge within a frame, None if it is refused; the time of a hundred readings without a mistake [s]."""
    assert read(BODY) is None, "the same mistake is no longer refused outside of a frame"
    begun = time.process_time()
    for _ in range(100):
        read_checked(SOUND, mended)
    took = time.process_time() - begun
    return read_checked(BODY, mended), took


MENDED = "--mended" in sys.argv
model, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a reading")
print(
    f"{'gone' if model is None else 'stands' if MENDED else 'still there'}: "
    "a misspelt damping of 0.5 is "
    + ("refused within a frame" if model is None else f"read as {model.dof_damping[0]:g} within a frame")
)
