"""A scene: bodies, joints, surfaces and sensors in SI units, as frozen values that validate themselves on construction."""

from dataclasses import is_dataclass

from plumbline.harness.scene.body import Appearance, Body, PlacedShape, Sun
from plumbline.harness.scene.joint import (
    WORLD,
    Ball,
    Coupling,
    Distance,
    Drive,
    Fixed,
    Joint,
    Limits,
    MomentArm,
    Prismatic,
    Revolute,
    Spring,
    Tendon,
)
from plumbline.harness.scene.motion import (
    Motion,
    Prescribed,
    Samples,
    Shift,
    Sinusoid,
    Turn,
    axis_angle,
    multiply,
    rotate,
    rotation_matrix,
    sampled,
)
from plumbline.harness.scene.scene import EARTH_GRAVITY, Effect, Scene, SceneError, Surface, refuse_in_words
from plumbline.harness.scene.sensor import (
    AxisNoise,
    Camera,
    DepthCamera,
    DepthNoise,
    Distortion,
    Imu,
    ImuNoise,
    Lidar,
    LidarNoise,
    Sensor,
    StereoNoise,
    StructuredLightNoise,
    TimeOfFlightNoise,
)
from plumbline.harness.scene.shape import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Plane,
    Shape,
    Sphere,
    TriangleMesh,
    box_inertia,
    capsule_inertia,
    cylinder_inertia,
    ellipsoid_inertia,
    outer_radius,
    polyhedron_of,
    principal_inertia,
    sphere_inertia,
    width,
)
from plumbline.harness.scene.values import Matrix3, Quaternion, Vector3

__all__ = [
    "EARTH_GRAVITY", "WORLD", "Appearance", "AxisNoise", "Ball", "Body", "Box", "Camera", "Capsule", "ConvexHull", "Coupling",
    "Cylinder", "DepthCamera", "DepthNoise", "Distance", "Distortion", "Drive", "Effect", "Ellipsoid", "Fixed", "Imu",
    "ImuNoise", "Joint", "Lidar", "LidarNoise", "Limits", "Matrix3", "MomentArm", "Motion", "PlacedShape", "Plane",
    "Prescribed", "Prismatic", "Quaternion", "Revolute", "Samples", "Scene", "SceneError", "Sensor", "Shape", "Shift",
    "Sinusoid", "Sphere", "Spring", "StereoNoise", "StructuredLightNoise", "Sun", "Surface", "Tendon", "TimeOfFlightNoise",
    "TriangleMesh", "Turn", "Vector3", "axis_angle", "box_inertia", "capsule_inertia", "cylinder_inertia", "ellipsoid_inertia",
    "multiply", "outer_radius", "polyhedron_of", "principal_inertia", "rotate", "rotation_matrix", "sampled", "sphere_inertia",
    "width",
]  # fmt: skip

refuse_in_words(noun for noun in map(globals().get, __all__) if isinstance(noun, type) and is_dataclass(noun))
