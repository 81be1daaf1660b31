"""How far an engine promises the same bits: an option that `resolved` names where that is less than everywhere."""

from collections.abc import Mapping
from typing import Any

BITS, OF_ONE_MACHINE = "bits", "of one machine"
"""The option, and its value where a step asks a library whose last bits go with the processor, like LAPACK."""


def only_here(resolved: Mapping[str, Any]) -> bool:
    """Do these settings promise their bits on one machine alone? Args: resolved: as a record has them."""
    return bool(resolved.get("options", {}).get(BITS) == OF_ONE_MACHINE)
