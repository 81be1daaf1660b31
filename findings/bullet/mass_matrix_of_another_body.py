# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "calculateMassMatrix answers for the body as it was when first asked, and after removeBody for a body that is gone"
# seen = ["3.2.7"]
# documented = "calculateMassMatrix computes the system inertia of an articulated body from its joint positions. The source stores a tree for each body at the first call, by its address, and clears them in resetSimulation alone."
# sources = [
#   "PyBullet Quickstart Guide, calculateMassMatrix",
#   "sdist of pybullet 3.2.7, examples/SharedMemory/PhysicsServerCommandProcessor.cpp: findOrCreateTree, m_inverseDynamicsBodies",
# ]
# mend = "ask in a client of its own, connect(DIRECT) and disconnect(), once the body is as it shall be"
# cases = []
# ///
"""Arms of 1 to 4 kg, each with 0.1 kg m2 and its weight a metre from the hinge: m + 0.1 kg m2 are due. One is changed, the others made and removed in turn."""

import sys
import time

import pybullet as p

MASSES, MOMENT = (1.0, 2.0, 3.0, 4.0), 0.1


def arm(mass):
    """A hinge with a weight [kg] a metre from it."""
    body = p.createMultiBody(
        baseMass=0.0,
        linkMasses=[mass],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[1.0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[p.JOINT_REVOLUTE],
        linkJointAxis=[[0, 1, 0]],
    )
    p.changeDynamics(body, 0, mass=mass, localInertiaDiagonal=[MOMENT] * 3)
    return body


def asked(body, mass):
    """The moment about the hinge of an arm that is given another mass first [kg m2]."""
    p.changeDynamics(body, 0, mass=mass, localInertiaDiagonal=[MOMENT] * 3)
    return p.calculateMassMatrix(body, [0.0])[0][0]


def measure(mended):
    """The moments [kg m2], of an arm changed from 1 to 2 kg and of arms made and removed in turn; the time of asking [s]."""
    begun = time.process_time()
    p.connect(p.DIRECT)
    body = arm(MASSES[0])
    if not mended:
        p.calculateMassMatrix(body, [0.0])
    moments = [asked(body, MASSES[1])]
    for mass in MASSES:
        if mended:
            p.disconnect()
            p.connect(p.DIRECT)
        body = arm(mass)
        moments.append(asked(body, mass))
        p.removeBody(body)
    p.disconnect()
    return moments, time.process_time() - begun


MENDED = "--mended" in sys.argv
moments, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a matrix")
print(
    f"{'gone' if all(abs(moment - mass - MOMENT) < 1e-9 for moment, mass in zip(moments, (MASSES[1], *MASSES))) else 'stands' if MENDED else 'still there'}: "
    f"{moments[0]:.1f} kg m2 of an arm whose mass was changed, {MASSES[1] + MOMENT:g} are due; {', '.join(f'{m:.1f}' for m in moments[1:])} of arms made and "
    f"removed in turn, {', '.join(f'{mass + MOMENT:g}' for mass in MASSES)} are due"
)
