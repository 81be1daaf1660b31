"""Which engine, for what is wanted: requirements drop some, evidence ranks the rest, and the rank carries its doubt."""

from plumbline.harness.findings.selection.choose import Selection, choose
from plumbline.harness.findings.selection.wish import CRITERIA, Dropped, Preset, PresetError, Wish, preset_names, read_preset

__all__ = ["CRITERIA", "Selection", "Dropped", "Preset", "PresetError", "Wish", "choose", "preset_names", "read_preset"]
