# /// script
# requires-python = ">=3.11"
# dependencies = ["mujoco==4.0.0"]
#
# [tool.finding]
# engine = "mujoco"
# kind = "trap"
# title = "A state that is not a number is put back to the start of the simulation, and mj_step raises no error"
# seen = ["4.0.0"]
# documented = "On a bad state a warning is counted and the state is reset; option/flag/autoreset turns that off. The warning is also printed and written to MUJOCO_LOG.TXT."
# sources = ["MuJoCo, XML Reference: option/flag, autoreset"]
# mend = 'look at data.warning after each step, or <flag autoreset="disable"/>, which leaves the state as it is'
# cases = []
# ///
"""A body is given a velocity that is not a number; a program that looks at its numbers alone sees that they are finite. The console and the log say so."""

import math
import os
import sys
import tempfile
import time
from pathlib import Path

import mujoco


def measure(mended):
    """Is the state finite, the times before and after [s], lines on the console and in the log; the time of five hundred steps [s]."""
    flag = '<option><flag autoreset="disable"/></option>' * mended
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco>{flag}<worldbody><body pos="0 0 1"><freejoint/><geom type="sphere" size="0.1"/></body></worldbody></mujoco>'
    )
    data, begun = mujoco.MjData(model), time.process_time()
    for _ in range(500):
        mujoco.mj_step(model, data)
    took, before = time.process_time() - begun, data.time
    data.qvel[0] = math.nan
    home, screen = Path.cwd(), os.dup(2)
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as console:
        os.chdir(folder)
        os.dup2(console.fileno(), 2)
        mujoco.mj_step(model, data)
        os.dup2(screen, 2)
        os.chdir(home)
        console.seek(0)
        log = Path(folder) / "MUJOCO_LOG.TXT"
        lines = console.read().count(b"WARNING"), log.read_text().count("WARNING") if log.exists() else 0
    os.close(screen)
    return all(map(math.isfinite, [*data.qpos, *data.qvel])), before, data.time, lines, took


MENDED = "--mended" in sys.argv
finite, before, after, lines, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a step")
print(
    f"{'gone' if not (finite and after < before) else 'stands' if MENDED else 'still there'}: "
    f"time was {before:.3f} s and is {after:.3f} s, the state is {'finite' if finite else 'not finite'}, no error was raised; "
    f"{lines[0]} warnings on the console, {lines[1]} in the log"
)
