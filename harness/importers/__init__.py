"""Robot files read into scenes: URDF, MJCF and our own TOML and JSON, with what each element became said row by row."""

from harness.importers.fidelity import Fidelity, Outcome
from harness.importers.imported import Imported
from harness.importers.refusal import RobotError
from harness.importers.wishes import DROPPABLE, SCENARIOS, Wishes

__all__ = ["DROPPABLE", "SCENARIOS", "Fidelity", "Imported", "Outcome", "RobotError", "Wishes"]
