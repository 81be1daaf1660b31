"""A scene: bodies, joints, surfaces and sensors in SI units, as frozen values that validate themselves on construction."""

from harness.scene.body import Body, PlacedShape
from harness.scene.effect import Effect
from harness.scene.inertia import box_inertia, capsule_inertia, cylinder_inertia, principal_inertia, sphere_inertia
from harness.scene.joint import WORLD, Ball, Distance, Drive, Fixed, Joint, Limits, Prismatic, Revolute, Spring
from harness.scene.rotation import axis_angle, multiply, rotate, rotation_matrix
from harness.scene.scene import EARTH_GRAVITY, Scene, SceneError
from harness.scene.sensor import (
    AxisNoise,
    Camera,
    DepthCamera,
    DepthNoise,
    Imu,
    ImuNoise,
    Lidar,
    LidarNoise,
    Sensor,
)
from harness.scene.shape import Box, Capsule, ConvexHull, Cylinder, Plane, Shape, Sphere, TriangleMesh, width
from harness.scene.surface import Surface
from harness.scene.values import Matrix3, Quaternion, Vector3

__all__ = [
    "EARTH_GRAVITY",
    "WORLD",
    "AxisNoise",
    "Ball",
    "Body",
    "Box",
    "Camera",
    "Capsule",
    "ConvexHull",
    "Cylinder",
    "DepthCamera",
    "DepthNoise",
    "Distance",
    "Drive",
    "Effect",
    "Fixed",
    "Imu",
    "ImuNoise",
    "Joint",
    "Lidar",
    "LidarNoise",
    "Limits",
    "Matrix3",
    "PlacedShape",
    "Plane",
    "Prismatic",
    "Quaternion",
    "Revolute",
    "Scene",
    "SceneError",
    "Sensor",
    "Shape",
    "Sphere",
    "Spring",
    "Surface",
    "TriangleMesh",
    "Vector3",
    "axis_angle",
    "box_inertia",
    "capsule_inertia",
    "cylinder_inertia",
    "multiply",
    "principal_inertia",
    "rotate",
    "rotation_matrix",
    "sphere_inertia",
    "width",
]
