"""Tables that are worked out from a run folder's rows: one file a table with its `TABLE`, found by walking the folder."""

import pkgutil
from importlib import import_module
from typing import cast

from plumbline.harness.findings.columns import Table


def names() -> list[str]:
    """The tables of this folder, without importing them."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def table(name: str) -> Table:
    """A table by its name, one of `names()`."""
    return cast(Table, import_module(f"{__name__}.{name}").TABLE)
