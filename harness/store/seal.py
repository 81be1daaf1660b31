"""Seals: a digest of a file's name and of every byte before it, kept at the file's own end.

Zip archives (npz) hold it as their comment, JSON as the last field, TOML as a comment: whoever reads these formats knows
nothing of it. A bit that flips anywhere, a file cut short and one under another's name break it.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plumbline.harness.store import disk

_DIGITS = 64
_BEFORE, _BEHIND = (
    {".npz": b"plumbline ", ".json": b',\n "checksum": "', ".toml": b"# checksum "},
    {".npz": b"", ".json": b'"\n}\n', ".toml": b"\n"},
)
_END = b"PK\x05\x06"
"""How the end of a zip archive's directory begins; without a comment it has 22 bytes, of which the last two are its length."""


class Damaged(Exception):
    """A file that is not what was written."""


def _seal(name: str, body: bytes | memoryview) -> bytes:
    kind, digest = Path(name).suffix, hashlib.sha256(name.encode() + b"\0")
    digest.update(body)
    return _BEFORE[kind] + digest.hexdigest().encode() + _BEHIND[kind]


def sealed_archive(name: str, archive: bytes) -> bytes:
    """The zip archive, which has no comment yet, with the seal of the file of that name. Raises: ValueError."""
    if archive[-22:-18] != _END or archive[-2:] != b"\0\0":
        raise ValueError(f"{name}: no zip archive without a comment")
    body = archive[:-2] + len(_seal(name, b"")).to_bytes(2, "little")
    return body + _seal(name, body)


def sealed_json(name: str, content: Mapping[str, Any]) -> bytes:
    """A JSON object that is not empty, with its seal as the last field, 'checksum'."""
    body = json.dumps(content, indent=1, allow_nan=False, default=str).removesuffix("\n}").encode()
    return body + _seal(name, body)


def sealed_toml(name: str, text: str) -> bytes:
    """A TOML text with its seal in the last line."""
    body = text.encode()
    return body + _seal(name, body)


def check_seal(path: Path, content: bytes) -> bool:
    """Whether a file has a seal, which those of other programs have not. Raises: Damaged, where it does not fit."""
    before, behind = _BEFORE[path.suffix], _BEHIND[path.suffix]
    start = len(content) - len(before) - _DIGITS - len(behind)
    if start < 0 or content[start : start + len(before)] != before:
        return False
    # A view of the bytes: a copy of a long trajectory would take as long as its digest.
    if content[start:] != _seal(path.name, memoryview(content)[:start]):
        raise Damaged("its content is not what was written under this name (its checksum differs)")
    return True


def require_seal(path: Path, content: bytes) -> None:
    """Raises: Damaged, where a file has no seal, or one that does not fit."""
    if not check_seal(path, content):
        raise Damaged("it has no checksum")


def read_sealed(path: Path) -> bytes:
    """All of a file that has its seal. Raises: Damaged, OSError."""
    content = disk.read(path)
    require_seal(path, content)
    return content
