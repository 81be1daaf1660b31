"""What names are called where people read of them: the tables of `words.toml`."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

WORDS: Mapping[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
"""By table, what each name is called, in the order in which they are shown."""
