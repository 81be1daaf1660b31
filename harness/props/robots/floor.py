"""The ground that robots stand on."""

from plumbline.harness.props.robots.robot import MATERIAL
from plumbline.harness.scene import Body, Box, Surface

SLAB_DEPTH = 0.5
PRESSED = 1e-6
"""How deep the soles start in the ground [m]: what just touches, some engines find a step late, and by then the drives have
thrown the feet about."""
SLAB = Box(half_extents=(5.0, 5.0, SLAB_DEPTH))
"""A box, since some engines find a box on a plane by one corner more in each step."""


def floor() -> Body:
    """The body 'ground' under soles at z = 0."""
    return Body.fixed("ground", SLAB, material="ground", p_WB=(0.0, 0.0, PRESSED - SLAB_DEPTH))


def grip(friction: float) -> Surface:
    """The friction of the ground under the parts of a robot."""
    return Surface.rough(friction, ("ground", MATERIAL))
