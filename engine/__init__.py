"""The reference physics engine: rigid bodies, joints, contacts, rays and pictures. It knows nothing of the harness."""

from typing import TYPE_CHECKING, Any

from plumbline.engine.describe.bodies import Body, Surface
from plumbline.engine.describe.errors import Diverged, ManyImpacts, NotSupported
from plumbline.engine.describe.joints import (
    WORLD,
    Ball,
    Coupling,
    Distance,
    Drive,
    Fixed,
    Joint,
    Limits,
    Prismatic,
    Revolute,
    Spring,
    Tendon,
)
from plumbline.engine.describe.optics import Optics, Sun
from plumbline.engine.describe.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Placed,
    Plane,
    Shape,
    Sphere,
    TriangleMesh,
)
from plumbline.engine.images.eye import Eye, Lens, Picture
from plumbline.engine.options import Options

if TYPE_CHECKING:
    from plumbline.engine.batch import Batch
    from plumbline.engine.contact.points import Contacts
    from plumbline.engine.rays.hits import Hits
    from plumbline.engine.world import World

__all__ = [
    "WORLD", "Ball", "Batch", "Body", "Box", "Capsule", "Contacts", "ConvexHull", "Coupling", "Cylinder", "Distance",
    "Diverged", "Drive", "Ellipsoid", "Eye", "Fixed", "Hits", "Joint", "Lens", "Limits", "ManyImpacts", "NotSupported",
    "Optics", "Options", "Picture", "Placed", "Plane", "Prismatic", "Revolute", "Shape", "Sphere", "Spring", "Sun", "Surface",
    "Tendon", "TriangleMesh", "World",
]  # fmt: skip

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Load the world, and with it the compiler, on first use."""
    if name in ("World", "Contacts", "Hits"):
        from plumbline.engine import world

        return getattr(world, name)
    if name == "Batch":
        from plumbline.engine.batch import Batch

        return Batch
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
