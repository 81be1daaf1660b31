"""Seeded mutants of text files: single bytes, and the words that a format is made of."""

import random
import re
from collections.abc import Callable, Sequence

__all__ = ["mutant"]

_TOKENS = re.compile(rb'"(?:[^"\\\n]|\\.)*"|[A-Za-z_][A-Za-z0-9_.-]*|[-+]?[0-9][0-9_.eE+-]*|\s+|.', re.DOTALL)
_NUMBERS: Sequence[bytes] = (
    *(b"0", b"-1", b"1e300", b"-1e300", b"1e-320", b"nan", b"inf", b"NaN", b"-Infinity", b"1e999", b"2e9", b"65536", b"1e-12"),
    *(b"9" * 25, b"9" * 5000, b"0." + b"3" * 2000, b"0x7fffffffffffffff", b"true", b'"5"', b"[]", b"{}", b"1979-05-27", b"00"),
)
_TEXTS: Sequence[bytes] = (
    *(
        b'""',
        b'"' + b"x" * 100_000 + b'"',
        b'"\\u001b[31m"',
        b'"\\ud800"',
        b'"../../etc"',
        b'"/"',
        b'"a\\u202eb"',
        b'"\\u0000"',
    ),
    *(b"'*'", b'"**[!a-"', b'"world"', b"'''", b'"""', b"5", b"null", b'"=cmd()"', b'"scene:x"', b'"nan"', '"ü😀"'.encode()),
)
_BYTES: Sequence[bytes] = (
    *(
        b"\x00",
        b"\xff",
        b"\x1b[2J",
        b"\xef\xbb\xbf",
        b"\xed\xa0\x80",
        "\u202e".encode(),
        b"\r",
        b"\x7f",
        b"\\",
        b'"',
        b"#",
        b"=",
    ),
    *(b"[", b"]", b"{", b"}", b"[[", b"]]", b",", b".", b"[" * 20_000, b"{" * 300, b"a." * 5_000, b"\n", b"[[bodies]]\n", b"-"),
)

Random = random.Random


def _flip(text: bytes, chance: Random) -> bytes:
    place = chance.randrange(len(text))
    return text[:place] + bytes([text[place] ^ 1 << chance.randrange(8)]) + text[place + 1 :]


def _part(text: bytes, chance: Random) -> tuple[int, int]:
    start = chance.randrange(len(text))
    return start, min(len(text), start + int(2 ** chance.uniform(0, 9)))


def _cut(text: bytes, chance: Random) -> bytes:
    start, end = _part(text, chance)
    return text[:start] + text[end:]


def _double(text: bytes, chance: Random) -> bytes:
    start, end = _part(text, chance)
    return text[:end] + text[start:end] * chance.choice((1, 1, 3, 50)) + text[end:]


def _move(text: bytes, chance: Random) -> bytes:
    start, end = _part(text, chance)
    rest, place = text[:start] + text[end:], chance.randrange(len(text))
    return rest[:place] + text[start:end] + rest[place:]


def _insert(text: bytes, chance: Random) -> bytes:
    place = chance.randrange(len(text))
    return text[:place] + chance.choice(_BYTES) + text[place:]


def _noise(text: bytes, chance: Random) -> bytes:
    place = chance.randrange(len(text))
    return text[:place] + chance.randbytes(chance.randrange(1, 9)) + text[place:]


def _truncate(text: bytes, chance: Random) -> bytes:
    return text[: chance.randrange(len(text))]


def _words(change: Callable[[list[bytes], int, Random], None]) -> Callable[[bytes, Random], bytes]:
    def changed(text: bytes, chance: Random) -> bytes:
        words = _TOKENS.findall(text)
        told = [place for place, word in enumerate(words) if not word.isspace()]
        if told:
            change(words, chance.choice(told), chance)
        return b"".join(words)

    return changed


def _other(words: list[bytes], place: int, chance: Random) -> None:
    """Another word of the same kind, or of another."""
    word = words[place]
    kind = _NUMBERS if word[:1].isdigit() or word[:1] in b"-+" else _TEXTS
    words[place] = chance.choice(kind if chance.random() < 0.8 else (*_NUMBERS, *_TEXTS))


def _value(words: list[bytes], place: int, chance: Random) -> None:
    """An unlikely number in place of one that is there."""
    numbers = [place for place, word in enumerate(words) if word[:1].isdigit()]
    words[chance.choice(numbers) if numbers else place] = chance.choice(_NUMBERS)


def _from_elsewhere(words: list[bytes], place: int, chance: Random) -> None:
    words[place] = chance.choice(words)


def _kind(word: bytes) -> str:
    return "number" if word[:1].isdigit() or word[:1] in b"-+" else "text" if word[:1] in b"\"'" else "sign"


def _alike(words: list[bytes], place: int, chance: Random) -> None:
    """A number or a text of the file in the place of another one, so that the file stays readable."""
    values = [place for place, word in enumerate(words) if _kind(word) != "sign"]
    here = chance.choice(values or [place])
    words[here] = chance.choice([word for word in words if _kind(word) == _kind(words[here])])


def _unlikely(words: list[bytes], place: int, chance: Random) -> None:
    """A number of the file, made unlikely, so that the file stays readable."""
    numbers = [place for place, word in enumerate(words) if _kind(word) == "number" and word[-1:].isdigit()]
    if numbers:
        words[chance.choice(numbers)] = chance.choice((b"0", b"-1", b"1e300", b"-2.5", b"1e-320", b"65536", b"1e-12", b"7"))


def _swap(words: list[bytes], place: int, chance: Random) -> None:
    other = chance.randrange(len(words))
    words[place], words[other] = words[other], words[place]


def _drop(words: list[bytes], place: int, _chance: Random) -> None:
    words[place] = b""


def _again(words: list[bytes], place: int, chance: Random) -> None:
    words[place] = b" ".join([words[place]] * chance.choice((2, 3, 100)))


def _lines(text: bytes, chance: Random) -> bytes:
    """A line or a block of lines twice, gone, or somewhere else."""
    lines = text.splitlines(keepends=True)
    start = chance.randrange(len(lines))
    end = min(len(lines), start + chance.choice((1, 1, 1, 3, 8)))
    block, rest = lines[start:end], lines[:start] + lines[end:]
    place = chance.randrange(len(rest) + 1)
    return b"".join(chance.choice((rest, rest[:place] + block + rest[place:], lines[:end] + block + lines[end:])))


_TAME: Sequence[Callable[[bytes, Random], bytes]] = (_lines, *(_words(way) for way in (_alike, _alike, _unlikely, _unlikely)))
_WILD: Sequence[Callable[[bytes, Random], bytes]] = (
    *(_flip, _cut, _double, _move, _insert, _noise, _truncate, _lines, _lines),
    *(_words(way) for way in (_other, _other, _value, _value, _value, _from_elsewhere, _swap, _drop, _again)),
)


def mutant(text: bytes, seed: int) -> bytes:
    """The text with one to four faults that the seed decides; at least one byte long. In every second one words stay words."""
    chance = random.Random(seed)
    ways = _TAME if seed % 2 else _WILD
    for _ in range(chance.choice((1, 1, 1, 2, 2, 3, 4))):
        text = chance.choice(ways)(text, chance) or b" "
    return text
