"""A process of its own in which one engine's loader reads one robot file: `python -m harness.run.loader_child`.

Arguments: adapter, variant, file, and where the outcome goes as JSON: what was loaded, or why it was not.
"""

import json
import sys
from pathlib import Path

from harness.adapter import Unavailable, Unsupported
from harness.scene.parity.loaded import stored
from harness.study import plugins

__all__: list[str] = []


def main(name: str, variant: str, file: str, out: str) -> None:
    """Load and write."""
    try:
        told = stored(plugins.adapter(name).load_robot(Path(file), variant))
    except (Unavailable, Unsupported) as error:
        told = {"why": str(error)}
    Path(out).write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
