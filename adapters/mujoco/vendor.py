"""The vendor's module: how it is loaded, its constants, when its state counts as lost, what older versions take."""

from collections.abc import Iterable
from typing import Any, NoReturn

import numpy as np

from plumbline.harness.adapter import Unavailable, Unsupported

OPEN = 1e10
"""A bound that no coordinate reaches: MuJoCo calls a state above it diverged (mjMAXVAL)."""
_FATAL = ("BADQPOS", "BADQVEL", "BADQACC")


def mujoco_module() -> Any:
    """The module mujoco, its log file and console lines off: `warnings` and `Diverged` say the same. Raises: Unavailable."""
    try:
        import mujoco
    except (ImportError, OSError) as error:
        raise Unavailable(f"mujoco cannot be imported ({error}); pip install mujoco") from error
    # Versions before 3.10 have no such switch: what they print goes to the log of the trial.
    if hasattr(mujoco, "MjLogConfig"):
        log = mujoco.MjLogConfig.get()
        if log.logto_file or log.logto_console:
            log.logto_file = log.logto_console = False
            log.set()
    return mujoco


def counters(mj: Any) -> tuple[str, ...]:
    """The names of mjData's warning counters in their order, which is not the same in all versions."""
    named = sorted((int(number), name) for name, number in mj.mjtWarning.__members__.items() if name != "mjNWARNING")
    return tuple(name.removeprefix("mjWARN_") for _, name in named)


def fatal(mj: Any) -> list[int]:
    """The places of those among these counters that say that a state is lost."""
    return [place for place, name in enumerate(counters(mj)) if name in _FATAL]


def flag(mj: Any, kind: str, name: str) -> int:
    """The number of a constant of one of the vendor's enumerations. Raises: Unsupported, where the version has none such."""
    constant = getattr(getattr(mj, kind, None), name, None)
    if constant is None:
        raise Unsupported(name.partition("_")[2].lower(), f"MuJoCo {mj.__version__} has no {name}")
    return int(constant)


def refuse(mj: Any, what: str) -> NoReturn:
    """Raises: Unsupported, where a version has no such thing as is named."""
    raise Unsupported(what, f"MuJoCo {mj.__version__} has another form of it")


def linear_law(current: Any, coefficient: float) -> list[float] | float:
    """A linear stiffness or damping in the form of the one that an element has: a polynomial, in older versions a number."""
    return [coefficient, 0.0, 0.0] if np.ndim(current) else coefficient


def set_equality(made: Any, parameters: Iterable[float]) -> None:
    """Give an equality its first parameters; the others are zero: 12 in all, 11 in older versions."""
    first = list(parameters)
    made.data = [*first, *([0.0] * (len(made.data) - len(first)))]
