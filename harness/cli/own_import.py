"""Between a robot file and a run of it: the import, kept in the run folder, and what is refused before anything runs."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.robot_options import imported_from, is_robot


def scene_to_run(name: str, folder: Path, options: dict[str, Any]) -> str:
    """The path of the scene file that is run: a file of our own as it is, another format's import in the run folder.

    Raises: RobotError, SceneError, OSError.
    """
    path = Path(name)
    asked = any(options.values())
    if not is_robot(path) and not asked:
        return name

    from plumbline.harness.store.imported_scenes import keep

    imported = imported_from(path, options, looks=True)
    of_run = {key: options[key] for key in ("dt", "duration") if options.get(key) is not None}
    imported = replace(imported, **of_run)
    counts = {word: sum(row.outcome == word for row in imported.fidelity) for word in ("exact", "approximated", "left_out")}
    summary = ", ".join(f"{count} kinds of elements {word.replace('_', ' ')}" for word, count in counts.items())
    say(f"{imported.source}: {summary}; show --table fidelity lists them", err=True)
    for row in imported.fidelity:
        if row.element == "start" and row.outcome == "exact":
            say(f"joint '{row.name}' starts at {row.becomes}: {row.consequence} {row.value:.3g} {row.unit}", err=True)
    if imported.dropped:
        say(f"dropped by the user: {', '.join(imported.dropped)}", err=True)
    return str(keep(folder, imported))
