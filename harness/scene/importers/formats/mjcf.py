"""MJCF: MuJoCo's format. A file with its endings whose root element is <robot> is a URDF."""

from plumbline.harness.scene.importers.importer import Importer, late

IMPORTER = Importer(name="mjcf", title="MJCF", endings=(".xml", ".mjcf"), read=late("mjcf"))
