"""What records of older schemas say in the words of the present one."""

from collections.abc import Iterable

from plumbline.harness.store.notices import StoredNotice


def notices_in_sentences(sentences: Iterable[str]) -> tuple[StoredNotice, ...]:
    """The warnings of a record of schema 2 or 1, and of a table without its journal.

    They are sentences. One about an effect begins with 'surplus: ' or 'missing: ', and names it as code or people do.
    """
    return tuple(map(_notice, sentences))


def base_of_track(track: str) -> str:
    """What a track of schema 2 or 1 descends from: what was turned in it stands behind a comma."""
    return track.partition(",")[0]


def change_in_name(variant: str) -> tuple[str, str] | None:
    """The track or variant, and what is changed in it, of a variant in a study that has no field for them."""
    beside, _, change = variant.rpartition(" ")
    return (beside, change) if beside and change in ("iterations", "law") else None


def _notice(sentence: str) -> StoredNotice:
    from plumbline.harness.scene import Effect  # late: who reads no old record does not pay for scenes

    words = sentence.lower().replace(",", " ").replace(":", " ").replace("(", " ").split()
    effect = next((name for name in Effect(~0).names if name in words or name.replace("_", " ") in " ".join(words)), "")
    if sentence.startswith("surplus: "):
        return StoredNotice(sentence.removeprefix("surplus: "), "surplus", effect)
    if sentence.startswith("missing: "):
        return StoredNotice(sentence.removeprefix("missing: "), "missing", effect)
    return StoredNotice(sentence)
