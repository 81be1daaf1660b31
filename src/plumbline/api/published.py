"""What today's engines are worth without running anything: the dataset that ships with the package."""

from typing import TYPE_CHECKING

from plumbline.api.results import Results

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


def open_published() -> Results:
    """The run that ships with Plumbline: its trials, prices and all tables but those that need trajectories.

    `published().store.machine` says when and where it was made. Raises: PlumblineError, where there is none, or it is damaged.
    """
    from plumbline.harness.store.published import published

    return Results(published())


def published_in_words(store: "Store") -> list[str]:
    """Where the dataset comes from, and which engines are installed here in another version, a sentence each."""
    from plumbline.harness.study import plugins

    machine, study = store.machine, store.study
    sentences = [
        f"Published figures: {study.get('title') or study.get('name')}, {len(store.trials)} trials, "
        f"{str(machine.get('started', ''))[:10]}, {machine.get('processor') or 'processor not known'}."
    ]
    names = plugins.names("adapters")
    for engine, version in dict(zip(store.trials["engine"], store.trials["engine_version"], strict=True)).items():
        installed, reason = plugins.version_of(plugins.adapter(engine)) if engine in names else ("none", "no adapter")
        if installed != version:
            current = f"installed is {installed}" if reason is None else f"not installed ({reason})"
            sentences.append(f"{store.titles.get(engine, engine)}: published with {version}, {current}.")
    return sentences
