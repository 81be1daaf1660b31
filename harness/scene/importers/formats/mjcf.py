"""MJCF: MuJoCo's format. A file with its endings whose root element is <robot> is a URDF."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.harness.scene.importers.importer import Importer, Reading

if TYPE_CHECKING:
    from plumbline.harness.scene.importers.robot import Robot


def read(path: Path, reading: Reading) -> "Robot":
    """The robot of an MJCF file. Raises: RobotError."""
    from plumbline.harness.intake.documents import named  # late, all of them: endings are asked for more often than robots
    from plumbline.harness.scene.importers import mjcf, urdf
    from plumbline.harness.scene.importers.files import text_of
    from plumbline.harness.scene.importers.xml_text import elements

    where = named(path)
    root = elements(text_of(path, where), where)
    if root.tag == "robot":
        return urdf.read(path, reading)
    said = reading.companion
    return replace(mjcf.read(path, root, reading.folders, said.keyframe, said.cameras), wordless=frozenset({"speed"}))


IMPORTER = Importer(name="mjcf", title="MJCF", endings=(".xml", ".mjcf"), read=read)
