"""What names are called, and sentences with room for names, where findings are told: the tables of `words.toml`."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

SPOKEN: Mapping[str, Any] = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
"""By table."""
