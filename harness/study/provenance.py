"""What an answer rests on: the texts of the adapter, the case, the truth and the harness, and the versions beside them.

An answer is kept under a name that covers all of these, so that a run which goes on after one has changed mixes nothing.
"""

import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from plumbline.harness.scene.importers.companion import beside
from plumbline.harness.study import plugins, sources

_ANSWERING = ("plumbline.harness.trial.accuracy", "plumbline.harness.trial.ensemble", "plumbline.harness.case.alteration")
"""From scene to record: what they import steps, samples, alters and measures."""
_WORDS = {
    "adapter": "the adapter's source",
    "case": "the case's source",
    "harness": "the harness that steps and measures",
    "truth": "the engine that makes the truth",
}


@cache
def _modules(kind: str, name: str) -> frozenset[str]:
    if kind == "cases" and name.startswith(plugins.SCENE_PREFIX):
        return sources.closure(["plumbline.harness.case.scene_file"])
    module = plugins.module_of(kind, name)
    return sources.closure([] if module is None else [module])


@cache
def _harness() -> frozenset[str]:
    return sources.closure(_ANSWERING)


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
        "case": _case_digest(case),
        "harness": sources.digest_of(_harness()),
        "libraries": sources.libraries(),
    }
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
    modules = {*_harness()}
    for case in cases:
        modules |= _modules("cases", case) | _truth(case)
    for engine in engines:
        modules |= _modules("adapters", engine)
    return sources.file_digests(modules)


def _files_of_origin(origin: str, case: str, engine: str) -> frozenset[str]:
    if origin == "harness":
        return _harness()
    if origin == "truth":
        return _truth(case)
    return _modules("cases", case) if origin == "case" else _modules("adapters", engine)


def what_changed(case: str, engine: str, was: Mapping[str, str], files: Mapping[str, str]) -> str:
    """In words, how the sources of an answer differ from today's; '' where they do not.

    Args: was: what `sources_of` gave then; files: what `files_of` gave then.
    """
    now, changes = sources_of(case, engine), []
    if not was:
        return "an earlier version of plumbline, which did not say what an answer rests on"
    for origin in (*now, *(origin for origin in was if origin not in now)):
        before, after = was.get(origin, "none"), now.get(origin, "none")
        if before == after:
            continue
        if origin == "libraries":
            changes.append(f"libraries: {before} -> {after}")
            continue
        today = sources.file_digests(_files_of_origin(origin, case, engine))
        names = [name for name, digest in today.items() if files.get(name) != digest]
        shown = f"{', '.join(names[:3])}{f' and {len(names) - 3} more' if len(names) > 3 else ''}" or "what it imports"
        changes.append(f"{_WORDS.get(origin, origin)} changed: {shown}")
    return "; ".join(changes)
