"""What a comparison leaves on disk: for a pull request, a build server, other trackers of benchmarks, and a page's corner."""

import json
from collections.abc import Callable, Collection
from dataclasses import asdict
from typing import Any

from plumbline.harness.findings.changes.badge import badge
from plumbline.harness.findings.changes.comment import comment
from plumbline.harness.findings.changes.exchange import asv, bencher
from plumbline.harness.findings.changes.junit import junit
from plumbline.harness.findings.changes.values import Changes
from plumbline.harness.findings.changes.words import command, sentence
from plumbline.harness.store.store import Store


def flat_rows(changes: Changes) -> list[dict[str, Any]]:
    """The rows as flat mappings, each with its sentence and its command."""
    return [
        asdict(row) | {"regression": row.regression, "sentence": sentence(row), "command": command(row, changes)}
        for row in changes.rows
    ]


def changes_files(changes: Changes, store: Store, gated: Collection[str] = (), least: float = 0.0) -> dict[str, bytes]:
    """The content of each file by name.

    Args: store: of B, whose figures are exported. gated: those that may not be worse. least: see `gate_in_short`.
    """
    made: dict[str, Callable[[], str]] = {
        "changes.json": lambda: json.dumps(flat_rows(changes), indent=1, default=str),
        "summary.md": lambda: comment(changes, gated, least),
        "junit.xml": lambda: junit(changes, store, gated, least),
        "asv.json": lambda: json.dumps(asv(store), indent=1, allow_nan=False),
        "bencher.json": lambda: json.dumps(bencher(store), indent=1, allow_nan=False),
        "badge.svg": lambda: badge(changes, gated),
    }
    return {name: make().encode() for name, make in made.items()}
