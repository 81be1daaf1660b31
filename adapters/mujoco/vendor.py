"""The vendor's module: how it is loaded, how its constants are named, when its state counts as lost."""

from typing import Any

from harness.adapter import Unavailable

__all__ = ["FATAL", "OPEN", "flag", "mujoco_module"]

OPEN = 1e10
"""A bound that no coordinate reaches: MuJoCo calls a state above it diverged (mjMAXVAL)."""
FATAL = slice(3, 6)
"""Places of BADQPOS, BADQVEL and BADQACC among mjData's warning counters."""


def mujoco_module() -> Any:
    """The module mujoco, its log file and console lines off: `warnings` and `Diverged` say the same. Raises: Unavailable."""
    try:
        import mujoco
    except (ImportError, OSError) as error:
        raise Unavailable(f"mujoco cannot be imported ({error}); pip install mujoco") from error
    log = mujoco.MjLogConfig.get()
    if log.logto_file or log.logto_console:
        log.logto_file = log.logto_console = False
        log.set()
    return mujoco


def flag(mj: Any, kind: str, name: str) -> int:
    """The number of a constant of one of the vendor's enumerations."""
    return int(getattr(getattr(mj, kind), name))
