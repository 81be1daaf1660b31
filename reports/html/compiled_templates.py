"""Compiled templates on disk: the first report that a machine makes of a version compiles them, the others read them.

What of a constant goes through a filter is worked out when a template is compiled, so that a name stands for all that this may
depend on. What was damaged, or may be another user's, is compiled anew, never run.
"""

import hashlib
import inspect
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from jinja2.bccache import Bucket, BytecodeCache, bc_magic

from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept


class CompiledTemplates(BytecodeCache):
    """Those of an environment. Args: filters: what its templates call; they rest on all modules of `html` and `words` too."""

    def __init__(self, filters: Iterable[Any]) -> None:
        texts = {Path(inspect.getfile(inspect.unwrap(call))) for call in filters}
        texts |= {path for room in ("html", "words") for path in (Path(__file__).parents[1] / room).glob("*.py")}
        digest = hashlib.sha256(bc_magic + version("jinja2").encode())
        for path in sorted(texts):
            digest.update(hashlib.sha256(path.read_bytes()).digest())
        self._rests_on = digest.digest()

    def get_cache_key(self, name: str, filename: str | None = None) -> str:  # noqa: ARG002  # the same wherever it lies
        """Its name within the folder of templates."""
        return name

    def load_bytecode(self, bucket: Bucket) -> None:
        """Take the compiled template over, where it is kept whole."""
        if content := read_kept(self._place(bucket)):
            bucket.bytecode_from_string(content)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep it; where nothing can be kept it is compiled each time."""
        keep(self._place(bucket), bucket.bytecode_to_string())

    def _place(self, bucket: Bucket) -> Path:
        """Its file, by its name, its text and what else it rests on."""
        named = f"{bucket.key}\0{bucket.checksum}".encode()
        return cache_folder("templates") / hashlib.sha256(self._rests_on + named).hexdigest()
