"""Inertia tensors [kg m2] of uniform solids about their centre of mass, in the frame of the shape.

Source: Goldstein, Classical Mechanics, 3rd ed., section 5.3 and exercises.
"""

from plumbline.harness.scene.shape import Box, Capsule, Cylinder, Ellipsoid, Shape, Sphere
from plumbline.harness.scene.values import Matrix3, Vector3


def principal_inertia(xx: float, yy: float, zz: float) -> Matrix3:
    """The diagonal tensor with the principal moments xx, yy, zz [kg m2]."""
    return ((xx, 0.0, 0.0), (0.0, yy, 0.0), (0.0, 0.0, zz))


def sphere_inertia(mass: float, radius: float) -> Matrix3:
    """A solid sphere: 2/5 m r^2."""
    moment = 0.4 * mass * radius**2
    return principal_inertia(moment, moment, moment)


def box_inertia(mass: float, half_extents: Vector3) -> Matrix3:
    """A solid box with half extents (a, b, c): m/3 (b^2 + c^2), ..."""
    a, b, c = half_extents
    return principal_inertia(mass / 3 * (b * b + c * c), mass / 3 * (a * a + c * c), mass / 3 * (a * a + b * b))


def ellipsoid_inertia(mass: float, semi_axes: Vector3) -> Matrix3:
    """A solid ellipsoid with semi-axes (a, b, c): m/5 (b^2 + c^2), ..."""
    a, b, c = semi_axes
    return principal_inertia(mass / 5 * (b * b + c * c), mass / 5 * (a * a + c * c), mass / 5 * (a * a + b * b))


def cylinder_inertia(mass: float, radius: float, half_length: float) -> Matrix3:
    """A solid cylinder along z: m (r^2/4 + h^2/3) across, m r^2/2 along, h the half length."""
    across = mass * (radius**2 / 4 + half_length**2 / 3)
    return principal_inertia(across, across, mass * radius**2 / 2)


def capsule_inertia(mass: float, radius: float, half_length: float) -> Matrix3:
    """A solid capsule along z: a cylinder of half length h between two half balls.

    The half balls' centroids lie 3r/8 beyond the cylinder's ends (parallel-axis theorem).
    """
    cylinder_volume = 2 * half_length * radius**2
    ball_volume = 4 / 3 * radius**3
    m_c = mass * cylinder_volume / (cylinder_volume + ball_volume)
    m_b = mass - m_c
    along = m_c * radius**2 / 2 + m_b * 2 / 5 * radius**2
    across = m_c * (radius**2 / 4 + half_length**2 / 3) + m_b * (
        2 / 5 * radius**2 + half_length**2 + 3 / 4 * half_length * radius
    )
    return principal_inertia(across, across, along)


def solid_inertia(mass: float, shape: Shape) -> Matrix3:
    """A solid of one of the five round or square shapes. Raises: TypeError for another, which has no such formula."""
    match shape:
        case Sphere(radius=radius):
            return sphere_inertia(mass, radius)
        case Box(half_extents=half_extents):
            return box_inertia(mass, half_extents)
        case Ellipsoid(semi_axes=semi_axes):
            return ellipsoid_inertia(mass, semi_axes)
        case Cylinder(radius=radius, half_length=half_length):
            return cylinder_inertia(mass, radius, half_length)
        case Capsule(radius=radius, half_length=half_length):
            return capsule_inertia(mass, radius, half_length)
        case _:
            raise TypeError(f"a {shape.type.replace('_', ' ')} has no inertia of its own, expected it beside the shape")
