"""What an answer rests on: the texts of the adapter, the case, the truth and the harness, and the versions beside them.

An answer is kept under a name that covers all of these, so that a run which goes on after one has changed mixes nothing. Those
that move a run are told apart from those that only judge it by what the code that steps imports: of a case it sees a `Problem`,
which enters by value, and whatever it imports moves.
"""

import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from plumbline.harness.scene.importers.companion import beside
from plumbline.harness.study import plugins, sources

_STEPPING = ("plumbline.harness.trial.answer", "plumbline.harness.case.alteration")
"""From problem to answer: what they import steps, samples and alters."""
_ANSWERING = ("plumbline.harness.trial.accuracy", "plumbline.harness.trial.ensemble", *_STEPPING)
"""From scene to record: what they import steps or measures."""


@cache
def _modules(kind: str, name: str) -> frozenset[str]:
    if kind == "cases" and name.startswith(plugins.SCENE_PREFIX):
        return sources.closure(["plumbline.harness.case.scene_file"])
    module = plugins.module_of(kind, name)
    return sources.closure([] if module is None else [module])


@cache
def _stepping() -> frozenset[str]:
    return sources.needed(_STEPPING)


@cache
def _harness() -> frozenset[str]:
    """What measures and does not step."""
    return sources.closure(_ANSWERING) - _stepping()


def _acts(case: str) -> bool:
    """Is the case's own code under way while an engine steps? A scene of one's own has none; a case that is not found may."""
    if case.startswith(plugins.SCENE_PREFIX):
        return False
    if plugins.module_of("cases", case) is None:
        return True
    question = plugins.case(case)
    return question.control is not None or question.retellings is not None


def _truth(case: str) -> frozenset[str]:
    own = case.startswith(plugins.SCENE_PREFIX) or plugins.module_of("cases", case) is None
    return frozenset() if own or plugins.case(case).coarsest is None else _modules("adapters", "reference")


@cache
def _case_digest(name: str) -> str:
    module_digest = sources.digest_of(_modules("cases", name))
    if not name.startswith(plugins.SCENE_PREFIX):
        return module_digest
    scene = Path(name.removeprefix(plugins.SCENE_PREFIX))
    files = [path.read_bytes() for path in (scene, beside(scene)) if path.is_file()]
    return hashlib.sha256(b"".join([module_digest.encode(), *files])).hexdigest()[:16]


@cache
def _said(case: str, engine: str) -> tuple[tuple[str, str], ...]:
    digests = {
        "adapter": sources.digest_of(_modules("adapters", engine)),
        "stepping": sources.digest_of(_stepping()),
        "case": _case_digest(case),
        "harness": sources.digest_of(_harness()),
        "libraries": sources.libraries(),
    }
    if _acts(case):
        digests["acting"] = digests["case"]
    if truth := _truth(case):
        digests["truth"] = sources.digest_of(truth)
    return tuple(digests.items())


def sources_of(case: str, engine: str) -> dict[str, str]:
    """Digests of the texts that decide what comes of a case on an engine, by what they are; 'libraries' in words.

    Raises: PluginError, SceneError.
    """
    return dict(_said(case, engine))


def files_of(cases: Iterable[str], engines: Iterable[str]) -> dict[str, str]:
    """The digest of every file behind `sources_of` for these cases and engines, by name."""
    modules = {*_harness(), *_stepping()}
    for case in cases:
        modules |= _modules("cases", case) | _truth(case)
    for engine in engines:
        modules |= _modules("adapters", engine)
    return sources.file_digests(modules)


def _files_of_origin(origin: str, case: str, engine: str) -> frozenset[str]:
    match origin:
        case "harness":
            return _harness()
        case "stepping":
            return _stepping()
        case "truth":
            return _truth(case)
        case "case" | "acting":
            return _modules("cases", case)
    return _modules("adapters", engine)


def moves_alike(case: str, engine: str, was: Mapping[str, str]) -> bool:
    """Are the sources that move a run those of today, whatever judges it? Args: was: what `sources_of` gave then."""
    now = sources_of(case, engine)
    return all(was.get(origin) == now.get(origin) for origin in sources.MOVING)


def what_changed(case: str, engine: str, was: Mapping[str, str], files: Mapping[str, str]) -> str:
    """In words, how the sources of an answer differ from today's; '' where they do not.

    Args: was: what `sources_of` gave then; files: what `files_of` gave then.
    """
    now, changes = sources_of(case, engine), []
    if not was:
        return "an earlier version of plumbline, which did not say what an answer rests on"
    for origin in (*now, *(origin for origin in was if origin not in now)):
        if origin == "acting":  # the case's source, told as that
            continue
        before, after = was.get(origin, "none"), now.get(origin, "none")
        if before == after:
            continue
        if origin == "libraries":
            changes.append(f"libraries: {before} -> {after}")
            continue
        today = sources.file_digests(_files_of_origin(origin, case, engine))
        names = [name for name, digest in today.items() if files.get(name) != digest]
        shown = f"{', '.join(names[:3])}{f' and {len(names) - 3} more' if len(names) > 3 else ''}" or "what it imports"
        changes.append(f"{sources.ORIGINS.get(origin, origin)} changed: {shown}")
    return "; ".join(changes)
