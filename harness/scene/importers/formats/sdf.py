"""SDF: Gazebo's format."""

from plumbline.harness.scene.importers.importer import Importer, late

IMPORTER = Importer(name="sdf", title="SDF", endings=(".sdf", ".world"), read=late("sdf"))
