"""What a scene of the user's own is called: by the name of its file, never by its path."""

from pathlib import PurePath

OWN = "scene:"
"""How the name of a case says that it lies in a file."""


def title_of(path: PurePath) -> str:
    """'My arm' of my_arm.toml."""
    words = " ".join(path.stem.replace("_", " ").replace("-", " ").split()) or path.stem
    return words[:1].upper() + words[1:]


def called(case: str) -> str:
    """The name of a case; of a scene of the user's own its title."""
    return title_of(PurePath(case.removeprefix(OWN))) if case.startswith(OWN) else case
