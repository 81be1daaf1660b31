"""MuJoCo's own compiler in a process of its own: a folder with model.xml in, out come its arrays, or what it says.

Run as a file, not imported: nothing of ours is loaded, memory and time are bounded, and a crash of the compiler costs nothing
but this process. Nothing is simulated here; the compiler stands where another format has a parser.
"""

import json
import re
import sys
from pathlib import Path
from typing import Any

OPTIONS = ("gravity", "wind", "density", "viscosity", "timestep", "disableflags")
MEMORY = 4 << 30
"""Bytes that the compiler may take."""
CPU = 60
"""Seconds of a core that it may take."""


def compiled() -> dict[str, Any]:
    """The arrays, names and options of model.xml in the present folder. Raises: ValueError, with what the compiler says."""
    import mujoco
    import numpy as np

    model = mujoco.MjSpec.from_file("model.xml").compile()
    held = {name: getattr(model, name) for name in dir(model) if not name.startswith("_")}
    kept: dict[str, Any] = {name: array for name, array in held.items() if isinstance(array, np.ndarray)}
    kept |= {f"opt_{name}": np.asarray(getattr(model.opt, name)) for name in OPTIONS}
    kept["names"] = np.frombuffer(model.names, np.uint8)
    kinds = {name: getattr(mujoco, name) for name in dir(mujoco) if name.startswith("mjt")}
    enums = {
        name.removeprefix("mjt"): {
            word.partition("_")[2].lower(): int(getattr(kind, word)) for word in dir(kind) if re.match("mj[A-Z]+_", word)
        }
        for name, kind in kinds.items()
    }
    kept["words"] = np.frombuffer(json.dumps({"enums": enums, "version": mujoco.__version__}).encode(), np.uint8)
    return kept


def schema() -> str:
    """What this compiler knows, as it prints it; nothing where there is none."""
    try:
        import mujoco
    except ImportError:
        return ""
    return str(mujoco.mj_printSchema(False, False))


def main(folder: str) -> None:
    """Compile what lies in a folder; out.npz or error.txt is there afterwards."""
    import os
    import resource

    os.chdir(folder)
    for limit, value in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, CPU), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(limit, (value, value))
    import numpy as np

    try:
        kept = compiled()
    except Exception as error:  # whatever the compiler raises is what it has to say
        Path("error.txt").write_text(f"{type(error).__name__}: {error}"[:20_000], encoding="utf-8", errors="replace")
        return
    finally:
        Path("schema.txt").write_text(schema(), encoding="utf-8")
    np.savez("out.npz", allow_pickle=False, **kept)


if __name__ == "__main__":
    main(sys.argv[1])
