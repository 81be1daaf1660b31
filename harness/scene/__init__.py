"""A scene: bodies, joints, surfaces and sensors in SI units, as frozen values that validate themselves on construction."""

from harness.scene.appearance import Appearance, Sun
from harness.scene.body import Body, PlacedShape
from harness.scene.camera import Camera, Distortion
from harness.scene.depth_camera import DepthCamera, DepthNoise, StereoNoise, StructuredLightNoise, TimeOfFlightNoise
from harness.scene.effect import Effect
from harness.scene.imu import AxisNoise, Imu, ImuNoise
from harness.scene.inertia import (
    box_inertia,
    capsule_inertia,
    cylinder_inertia,
    ellipsoid_inertia,
    principal_inertia,
    sphere_inertia,
)
from harness.scene.joint import WORLD, Ball, Coupling, Distance, Drive, Fixed, Joint, Limits, Prismatic, Revolute, Spring
from harness.scene.lidar import Lidar, LidarNoise
from harness.scene.motion import Motion, Samples, Sinusoid, sampled
from harness.scene.prescribed import Prescribed, Shift, Turn
from harness.scene.rotation import axis_angle, multiply, rotate, rotation_matrix
from harness.scene.scene import EARTH_GRAVITY, Scene, SceneError
from harness.scene.sensor import Sensor
from harness.scene.shape import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Plane,
    Shape,
    Sphere,
    TriangleMesh,
    outer_radius,
    polyhedron_of,
    width,
)
from harness.scene.surface import Surface
from harness.scene.values import Matrix3, Quaternion, Vector3

__all__ = [
    "EARTH_GRAVITY",
    "WORLD",
    "Appearance",
    "AxisNoise",
    "Ball",
    "Body",
    "Box",
    "Camera",
    "Capsule",
    "ConvexHull",
    "Coupling",
    "Cylinder",
    "DepthCamera",
    "DepthNoise",
    "Distance",
    "Distortion",
    "Drive",
    "Effect",
    "Ellipsoid",
    "Fixed",
    "Imu",
    "ImuNoise",
    "Joint",
    "Lidar",
    "LidarNoise",
    "Limits",
    "Matrix3",
    "Motion",
    "PlacedShape",
    "Plane",
    "Prescribed",
    "Prismatic",
    "Quaternion",
    "Revolute",
    "Samples",
    "Scene",
    "SceneError",
    "Sensor",
    "Shape",
    "Shift",
    "Sinusoid",
    "Sphere",
    "Spring",
    "StereoNoise",
    "StructuredLightNoise",
    "Sun",
    "Surface",
    "TimeOfFlightNoise",
    "TriangleMesh",
    "Turn",
    "Vector3",
    "axis_angle",
    "box_inertia",
    "capsule_inertia",
    "cylinder_inertia",
    "ellipsoid_inertia",
    "multiply",
    "outer_radius",
    "polyhedron_of",
    "principal_inertia",
    "rotate",
    "rotation_matrix",
    "sampled",
    "sphere_inertia",
    "width",
]
