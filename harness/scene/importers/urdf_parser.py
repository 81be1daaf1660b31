"""yourdfpy without the rest of trimesh: to parse a text it needs two functions of that, and all of it takes 0.7 s to load."""

import sys
from importlib import import_module
from importlib.machinery import PathFinder
from types import ModuleType
from typing import Any

_HEAVY = "trimesh"


class _Later(ModuleType):
    """Stands for trimesh while yourdfpy is loaded, which names its classes in annotations, and hands on to it from then on."""

    whole = False

    def __getattr__(self, name: str) -> Any:
        if not self.whole:
            return object
        return getattr(import_module(_HEAVY), name)


def yourdfpy_module() -> Any:
    """The module yourdfpy. Whoever imports trimesh, before or after, gets it whole. Raises: ImportError."""
    spec = None if _HEAVY in sys.modules or "yourdfpy" in sys.modules else PathFinder.find_spec(_HEAVY)
    if spec is None:
        return import_module("yourdfpy")
    later = _Later(_HEAVY)
    later.__path__ = list(spec.submodule_search_locations or ())
    sys.modules[_HEAVY] = later
    try:
        return import_module("yourdfpy")
    finally:
        later.whole = True
        for name in [name for name in sys.modules if name.partition(".")[0] == _HEAVY]:
            del sys.modules[name]
