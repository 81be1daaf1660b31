"""What changed from one run folder to another: values first, sentences and files last."""

from plumbline.harness.findings.changes.compare import compare
from plumbline.harness.findings.changes.values import Change, Changes, ComparedRun, Judged

__all__ = ["Change", "Changes", "Judged", "ComparedRun", "compare"]
