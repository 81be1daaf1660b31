"""The engine as a vendor: its version, and the folder that its compiled code is kept in."""

from plumbline.harness.adapter import Unavailable

__all__ = ["check_cache", "engine_version"]


def engine_version() -> str:
    """Version and digest of the engine's sources. Raises: Unavailable."""
    check_cache()
    from plumbline import engine
    from plumbline.engine.compile.sources import source_digest

    return f"{engine.__version__}+{source_digest()[:8]}"


def check_cache() -> None:
    """Raises: Unavailable, where compiled code has no folder that this user alone may write to."""
    from plumbline.engine.compile.kernel_cache import NoFolder, usable_root

    try:
        usable_root()
    except NoFolder as error:
        raise Unavailable(str(error)) from None
