"""The built-in adapters, found by walking their folder, each with the reason where its engine is not installed."""

import pkgutil
from functools import cache
from importlib import import_module

from plumbline import adapters
from plumbline.harness.adapter import Adapter, Unavailable
from plumbline.harness.conformance import CHECKS, CheckOutcome, run_check

__all__ = ["NAMES", "adapter", "outcome_of", "why_unavailable"]

NAMES = tuple(sorted(module.name for module in pkgutil.iter_modules(adapters.__path__)))
"""The names of the files in `adapters/`."""


@cache
def adapter(name: str) -> Adapter:
    """The adapter of that file; what its import raises is a defect of the file."""
    found = import_module(f"plumbline.adapters.{name}").ADAPTER
    assert isinstance(found, Adapter), f"adapters/{name}.py ends in no ADAPTER"
    return found


@cache
def why_unavailable(name: str) -> str:
    """Why the engine cannot be asked; empty where it can."""
    try:
        adapter(name).version()
    except Unavailable as reason:
        return f"{name}: {reason}"
    return ""


@cache
def outcome_of(name: str, track: str, check: str) -> CheckOutcome:
    """What a check says of an engine as it is; asked once in a process, by whichever test comes first."""
    (asked,) = (one for one in CHECKS if one.name == check)
    return run_check(adapter(name), track, asked)
