# /// script
# requires-python = "==3.11.*"
# dependencies = ["pybullet==3.2.7", "numpy"]
#
# [tool.finding]
# engine = "bullet"
# kind = "bug"
# title = "calculateMassMatrix refuses some sound trees"
# seen = ["3.2.7"]
# documented = "calculateMassMatrix computes the system inertia of an articulated body from its joint positions."
# sources = ["PyBullet Quickstart Guide, calculateMassMatrix"]
# mend = "try other joint positions, or take the inertia from forces: no setting helps"
# cases = []
# ///
"""Two hundred chains of three hinges with drawn lengths and axes: rounding leaves an inertia unsymmetric by an ulp, which is taken for an error."""

import numpy as np
import pybullet as p

p.connect(p.DIRECT)
draw, refused, COUNT = np.random.default_rng(1), 0, 200


def unit(rows, columns):
    drawn = draw.normal(size=(rows, columns))
    return (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)).tolist()


for _ in range(COUNT):
    tree = p.createMultiBody(
        baseMass=0.0,
        linkMasses=[1.0] * 3,
        linkCollisionShapeIndices=[-1] * 3,
        linkVisualShapeIndices=[-1] * 3,
        linkPositions=draw.normal(size=(3, 3)).tolist(),
        linkOrientations=unit(3, 4),
        linkInertialFramePositions=draw.normal(size=(3, 3)).tolist(),
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * 3,
        linkParentIndices=[0, 1, 2],
        linkJointTypes=[p.JOINT_REVOLUTE] * 3,
        linkJointAxis=unit(3, 3),
    )
    for link in range(3):
        p.changeDynamics(tree, link, mass=1.0 + link, localInertiaDiagonal=[0.1, 0.2, 0.25])
    try:
        p.calculateMassMatrix(tree, [0.1, 0.2, 0.3])
    except (p.error, SystemError):
        refused += 1
print(f"{'still there' if refused else 'gone'}: {refused} of {COUNT} trees are refused")
