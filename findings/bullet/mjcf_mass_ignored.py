# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "trap"
# title = "loadMJCF gives a geom 1000 kg/m³, whatever its own mass or density"
# seen = ["3.2.7"]
# documented = "MJCF: geom/mass and geom/density set a geom's mass; 1000 kg/m3 is the default density. The loader calls itself a basic import of MJCF files; it reads the mass of <inertial>."
# sources = [
#   "MuJoCo, XML Reference: geom, mass and density",
#   "PyBullet Quickstart Guide, loadMJCF",
#   "sdist of pybullet 3.2.7, examples/Importers/ImportMJCFDemo/BulletMJCFImporter.cpp: double density = 1000",
# ]
# mend = '<inertial pos="..." mass="..."/> in each body of the file (its diaginertia is not read), or changeDynamics(body, link, mass=...) after loading'
# cases = []
# ///
"""A ball, a box and a capsule that the file gives 2 kg, by their mass and by their density."""

import math
import sys
import tempfile
import time
from pathlib import Path

import pybullet as p

MASS = 2.0
VOLUMES = {
    'type="sphere" size="0.1"': 4 / 3 * math.pi * 0.1**3,
    'type="box" size="0.1 0.1 0.1"': 0.2**3,
    'type="capsule" size="0.1 0.1"': math.pi * 0.1**2 * 0.2 + 4 / 3 * math.pi * 0.1**3,
}


def measure(mended):
    """The masses of the three [kg], each by its mass and by its density, and the time of the loading [s]."""
    p.connect(p.DIRECT)
    masses, took = [], 0.0
    inertial = f'<inertial pos="0 0 0" mass="{MASS}"/>' * mended
    with tempfile.TemporaryDirectory() as folder:
        for shape, volume in VOLUMES.items():
            for attribute in (f'mass="{MASS}"', f'density="{MASS / volume!r}"'):
                path = Path(folder) / f"{len(masses)}.xml"
                path.write_text(
                    f'<mujoco><worldbody><body name="l">{inertial}<joint name="j" type="hinge" axis="0 1 0"/><geom {shape} {attribute}/>'
                    "</body></worldbody></mujoco>"
                )
                begun = time.process_time()
                body = max(p.loadMJCF(str(path)), key=p.getNumJoints)
                took += time.process_time() - begun
                masses.append(sum(p.getDynamicsInfo(body, joint)[0] for joint in range(p.getNumJoints(body))))
    p.disconnect()
    return masses, took


MENDED = "--mended" in sys.argv
masses, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a loading")
print(
    f"{'gone' if max(abs(mass - MASS) for mass in masses) < 1e-6 else 'stands' if MENDED else 'still there'}: "
    f"{', '.join(f'{mass:.3f}' for mass in masses)} kg of a ball, a box and a capsule, by mass and by density; the file gives each {MASS:g} kg"
)
