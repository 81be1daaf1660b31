"""The rerun viewer of the wheel: opened on a recording, or asked for the assets of its web edition."""

import os
import sys
from pathlib import Path
from subprocess import run

ENVIRONMENT = {"CI": "1", "TELEMETRY_ENABLED": "false"}
"""Rerun collects no usage figures under continuous integration; it knows no narrower switch outside its configuration file."""

NO_DISPLAY = 3


def viewer_command() -> list[str]:
    """The command that starts the viewer of this environment, whatever else is on the PATH."""
    return [sys.executable, "-m", "rerun_cli"]


def has_display() -> bool:
    """Can a window open here?"""
    return sys.platform in {"darwin", "win32"} or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_viewer(path: Path) -> int:
    """Show a recording until its window is closed; returns the viewer's exit code, 3 where no window can open."""
    if not has_display():
        folder = path.parent.parent
        print(
            f"{path}: no display here (neither DISPLAY nor WAYLAND_DISPLAY is set), so no viewer can open; "
            f"'plumbline serve {folder}' shows it in a browser, or copy the file and open it with: rerun {path.name}",
            file=sys.stderr,
        )
        return NO_DISPLAY
    # A port of its own: otherwise the recording would go to a viewer that is already open, and this call would not wait.
    return run([*viewer_command(), "--port", "auto", str(path)], env=os.environ | ENVIRONMENT, check=False).returncode
