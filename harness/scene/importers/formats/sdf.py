"""SDF: Gazebo's format."""

from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.harness.scene.importers.importer import Importer, Reading

if TYPE_CHECKING:
    from plumbline.harness.scene.importers.robot import Robot


def read(path: Path, reading: Reading) -> "Robot":
    """The robot of an SDF file. Raises: RobotError."""
    from plumbline.harness.scene.importers import sdf  # late: endings are asked for more often than robots

    return sdf.read(path, reading)


IMPORTER = Importer(name="sdf", title="SDF", endings=(".sdf", ".world"), read=read)
