"""What pybullet's mass matrix of a tree is refused by, in pybullet's own words."""

import numpy as np
import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet


def test_the_mass_matrix_of_some_trees_is_refused(world: World) -> None:
    """Rounding leaves the inertia of a body about its joint unsymmetric by an ulp, which the binding takes for an error."""
    draw, refused = np.random.default_rng(1), 0

    def turns(count: int) -> list[list[float]]:
        q = draw.normal(size=(count, 4))
        made: list[list[float]] = (q / np.linalg.norm(q, axis=1, keepdims=True)).tolist()
        return made

    for _ in range(200):
        axes = draw.normal(size=(3, 3))
        tree = world.createMultiBody(
            baseMass=0.0,
            linkMasses=[1.0] * 3,
            linkCollisionShapeIndices=[-1] * 3,
            linkVisualShapeIndices=[-1] * 3,
            linkPositions=draw.normal(size=(3, 3)).tolist(),
            linkOrientations=turns(3),
            linkInertialFramePositions=draw.normal(size=(3, 3)).tolist(),
            linkInertialFrameOrientations=[[0, 0, 0, 1]] * 3,
            linkParentIndices=[0, 1, 2],
            linkJointTypes=[pybullet.JOINT_REVOLUTE] * 3,
            linkJointAxis=(axes / np.linalg.norm(axes, axis=1, keepdims=True)).tolist(),
        )
        for link in range(3):
            world.changeDynamics(tree, link, mass=1.0 + link, localInertiaDiagonal=[0.1, 0.2, 0.25])
        try:
            world.calculateMassMatrix(tree, [0.1, 0.2, 0.3])
        except (pybullet.error, SystemError):
            refused += 1
    # One tree in forty or so: 200 hold five on average, and the numbers are the same each time.
    assert refused > 0
