"""URDF: the format of the Robot Operating System."""

from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.harness.scene.importers.importer import Importer, Reading

if TYPE_CHECKING:
    from plumbline.harness.scene.importers.robot import Robot


def read(path: Path, reading: Reading) -> "Robot":
    """The robot of a URDF file. Raises: RobotError."""
    from plumbline.harness.scene.importers import urdf  # late: endings are asked for more often than robots

    return urdf.read(path, reading)


IMPORTER = Importer(name="urdf", title="URDF", endings=(".urdf",), read=read)
