"""URDF: the format of the Robot Operating System."""

from plumbline.harness.scene.importers.importer import Importer, late

IMPORTER = Importer(name="urdf", title="URDF", endings=(".urdf",), read=late("urdf"))
