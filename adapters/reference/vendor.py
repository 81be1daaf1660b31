"""The engine as a vendor: its version, and the folder that its compiled code is kept in."""

import os
from pathlib import Path

from plumbline.harness.adapter import Unavailable

__all__ = ["check_cache", "engine_version"]


def engine_version() -> str:
    """Version and digest of the engine's sources. Raises: Unavailable."""
    check_cache()
    from plumbline import engine
    from plumbline.engine.compile.sources import source_digest

    return f"{engine.__version__}+{source_digest()[:8]}"


def check_cache() -> None:
    """Raises: Unavailable, where the folder for compiled code that the environment names can be none."""
    named = os.environ.get("PLUMBLINE_KERNEL_CACHE", "")
    there = next((path for path in (Path(named), *Path(named).absolute().parents) if os.access(path, os.F_OK)), Path("/"))
    if named and not (there.is_dir() and os.access(there, os.W_OK)):
        why = "cannot be written" if there.is_dir() else "is no folder"
        raise Unavailable(
            f"PLUMBLINE_KERNEL_CACHE: {named[:200]!r}: {there} {why}; unset it, or name a folder that can be made"
        )
