"""Planted faults: engines broken in exactly one way each, which the conformance checks and the cases must catch and name."""

from importlib import import_module

from tests.planted_faults import fault
from tests.planted_faults.fault import Fault

__all__ = ["FAULTS", "Fault"]

for subject in ("motion", "contact", "joints", "coordinates", "tendons", "pairs", "sensing", "contract"):
    import_module(f"tests.planted_faults.{subject}")

FAULTS = tuple(fault.FAULTS)
"""Every planted fault, in the order of the page."""
