"""A process of its own in which one engine's loader reads one robot file: `python -m harness.run.loader_child`.

Arguments: adapter, file, where the outcome goes as JSON (what was loaded, or why it was not), way, how a root is held, and the
folders of packages as NAME=DIR, each one argument.
"""

import json
import sys
from pathlib import Path

from plumbline.harness.adapter import Unavailable, Unsupported
from plumbline.harness.intake.import_wishes import Root
from plumbline.harness.scene.parity.loaded import Request, stored
from plumbline.harness.study import plugins


def main(name: str, file: str, out: str, way: str, root: Root, *packages: str) -> None:
    """Load and write."""
    folders = {package: Path(folder) for package, _, folder in (text.partition("=") for text in packages)}
    request = Request(way=way, root=root, packages=folders)
    try:
        answer = stored(plugins.adapter(name).load_robot(Path(file), request))
    except Unsupported as error:
        answer = {"what": error.what, "why": error.why}
    except Unavailable as error:
        answer = {"what": "the engine", "why": str(error)}
    Path(out).write_text(json.dumps(answer), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])  # type: ignore[arg-type]  # written by `importer_audit` alone
