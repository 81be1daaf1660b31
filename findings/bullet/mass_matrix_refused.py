# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7", "numpy"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "calculateMassMatrix refuses some sound trees"
# seen = ["3.2.7"]
# documented = "calculateMassMatrix computes the system inertia of an articulated body from its joint positions. The source takes an inertia that is unsymmetric by more than a fixed number for an error, however large its entries are."
# sources = [
#   "PyBullet Quickstart Guide, calculateMassMatrix",
#   "sdist of pybullet 3.2.7, src/BulletInverseDynamics/IDMath.cpp: isValidInertiaMatrix, kIsZero",
# ]
# mend = "masses and moments of a 1024th before the first call (a refusal sticks to the body), and the matrix times 1024: bit for bit the same"
# cases = []
# ///
"""Two hundred chains of three hinges with drawn lengths and axes: each has a mass matrix. Rounding leaves an inertia unsymmetric by an ulp, which is taken for an error."""

import sys
import time

import numpy as np
import pybullet as p

COUNT = 200


def matrix(draws, scale):
    """The mass matrix of a chain whose masses and moments are scaled, times the inverse of that; None if it is refused."""
    lengths, turns, centres, axes = draws
    tree = p.createMultiBody(
        baseMass=0.0,
        linkMasses=[1.0] * 3,
        linkCollisionShapeIndices=[-1] * 3,
        linkVisualShapeIndices=[-1] * 3,
        linkPositions=lengths,
        linkOrientations=turns,
        linkInertialFramePositions=centres,
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * 3,
        linkParentIndices=[0, 1, 2],
        linkJointTypes=[p.JOINT_REVOLUTE] * 3,
        linkJointAxis=axes,
    )
    for link in range(3):
        moments = [moment * scale for moment in (0.1, 0.2, 0.25)]
        p.changeDynamics(tree, link, mass=(1.0 + link) * scale, localInertiaDiagonal=moments)
    try:
        return np.array(p.calculateMassMatrix(tree, [0.1, 0.2, 0.3])) / scale
    except (p.error, SystemError):
        return None


def measure(mended):
    """How many trees are refused, and the time of making and asking [s]."""
    p.connect(p.DIRECT)
    draw = np.random.default_rng(1)

    def unit(rows, columns):
        drawn = draw.normal(size=(rows, columns))
        return (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)).tolist()

    drawn = [
        (draw.normal(size=(3, 3)).tolist(), unit(3, 4), draw.normal(size=(3, 3)).tolist(), unit(3, 3)) for _ in range(COUNT)
    ]
    begun = time.process_time()
    matrices = [matrix(draws, 1 / 1024 if mended else 1.0) for draws in drawn]
    took = time.process_time() - begun
    p.disconnect()
    return sum(found is None for found in matrices), took


MENDED = "--mended" in sys.argv
refused, _ = measure(MENDED)
if MENDED:
    plain, mended = (min(times) for times in zip(*((measure(False)[-1], measure(True)[-1]) for _ in range(3))))
    print(f"price: {mended / plain:.2f} of a matrix")
print(f"{'gone' if not refused else 'stands' if MENDED else 'still there'}: {refused} of {COUNT} trees are refused")
