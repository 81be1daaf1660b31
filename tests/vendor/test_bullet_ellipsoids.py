"""pybullet has no ellipsoid: no kind of shape is one, and a ball is not stretched by the scale that meshes know."""

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet


def test_no_kind_of_shape_is_an_ellipsoid() -> None:
    kinds = sorted(
        name for name in dir(pybullet) if name.startswith("GEOM_") and "FORCE" not in name and "INTERNAL" not in name
    )
    assert not any("ELLIPSOID" in kind for kind in kinds), kinds


def test_a_ball_with_a_scale_stays_a_ball(world: World) -> None:
    """Scaled by (1, 1, 3), a ray from above still meets it at its radius."""
    ball = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, meshScale=[1.0, 1.0, 3.0])
    world.createMultiBody(1.0, ball)
    (hit,) = world.rayTestBatch([[0.0, 0.0, 2.0]], [[0.0, 0.0, -2.0]])
    assert 2.0 - 4.0 * hit[2] == pytest.approx(0.1, abs=1e-3)
