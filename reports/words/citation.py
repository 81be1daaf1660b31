"""Cite this run: what a reader of a figure or a table needs to know where it came from."""

import hashlib

from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.store import Store


def run_digest(store: Store) -> str:
    """Sixteen hexadecimal digits over the answers of all trials and their names, which cover settings, versions, sources."""
    pairs = sorted(zip(store.trials["trial"], store.trials["trajectory_hash"].fillna(""), strict=True))
    return hashlib.sha256(repr([(str(trial), str(answer)) for trial, answer in pairs]).encode()).hexdigest()[:16]


def citation(store: Store) -> list[tuple[str, str]]:
    """Names and values: study, engines with versions, machine, when, our version and commit, the digest, how to repeat it."""
    machine = store.machine
    titles = {name: about.get("title") or name for name, about in store.catalogue.get("engines", {}).items()}
    engines = store.trials.groupby("engine", sort=False)["engine_version"].first() if len(store.trials) else {}
    memory = machine.get("memory_mb")
    about = [str(machine.get("processor", "")), f"{machine['cores']} cores" if machine.get("cores") else ""]
    about += [f"{memory / 1024:.0f} GiB" if memory else "", str(machine.get("system", ""))]
    command = machine.get("command") or ()
    rows = [
        ("study", str(store.study.get("name", ""))),
        ("engines", ", ".join(f"{titles.get(name, name)} {version}" for name, version in engines.items())),
        ("machine", ", ".join(part for part in about if part)),
        ("machine's digest", machine_digest(machine)),
        ("started", str(machine.get("started", ""))),
        ("Plumbline", str(machine.get("packages", {}).get("plumbline", ""))),
        ("commit", str(machine.get("commit", ""))),
        ("Python", str(machine.get("python", ""))),
        ("trials", str(len(store.trials))),
        ("run's digest", run_digest(store) if len(store.trials) else ""),
        ("command", " ".join(map(str, command))),
    ]
    return [(name, value) for name, value in rows if value]
