"""Sensors, mounted on a body (or the world) with a pose, a rate and a noise model: their closed union."""

from typing import Annotated

from pydantic import Field

from plumbline.harness.scene.camera import Camera
from plumbline.harness.scene.depth_camera import DepthCamera
from plumbline.harness.scene.imu import Imu
from plumbline.harness.scene.lidar import Lidar

Sensor = Annotated[Imu | Lidar | Camera | DepthCamera, Field(discriminator="type")]
