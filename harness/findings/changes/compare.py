"""Two run folders side by side: what of the second differs from the first."""

from harness.findings.changes.values import Changes
from harness.store.store import Store

__all__ = ["compare"]


def compare(store_a: Store, store_b: Store) -> Changes:
    """All that differs from `store_a` to `store_b`, heaviest first. Raises: StoreError."""
    raise NotImplementedError
