"""The program of rerun's web viewer, taken once from the viewer in the wheel, which carries it inside.

The wheel holds no files of it: its binary serves them. It is started on a free loopback port, asked for both files, and ended.
"""

import os
import re
import signal
import subprocess
import threading
from contextlib import suppress
from functools import cache
from http.client import HTTPException
from urllib.error import URLError
from urllib.request import ProxyHandler, build_opener

from plumbline.reports.recordings.viewer import ENVIRONMENT, viewer_command

FILES = ("re_viewer.js", "re_viewer_bg.wasm")

PATIENCE = 60.0
"""Seconds that the viewer may take to start."""

NO_RECORDING = "http://127.0.0.1:9/none.rrd"
"""With an address to show, the viewer opens no port for recordings. It hands the address to the browser and never asks it."""


class AssetsMissing(Exception):
    """The viewer did not give its program; the message says what it said instead."""


_lock = threading.Lock()


def viewer_file(name: str) -> bytes | None:
    """One of the viewer's files; None for any other name. Raises: AssetsMissing."""
    if name not in FILES:
        return None
    with _lock:
        return fetched()[name]


@cache
def fetched() -> dict[str, bytes]:
    """All files of the web viewer, about 43 MB."""
    command = [*viewer_command(), "--serve-web", "--bind", "127.0.0.1", "--web-viewer-port", "0", NO_RECORDING]
    environment = os.environ | ENVIRONMENT | {"BROWSER": "true", "NO_COLOR": "1"}
    viewer = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    alarm = threading.Timer(PATIENCE, _end, (viewer,))
    alarm.start()
    try:
        return _ask(viewer)
    finally:
        alarm.cancel()
        _end(viewer)


def _ask(viewer: "subprocess.Popen[str]") -> dict[str, bytes]:
    output: list[str] = []
    for line in viewer.stdout or ():
        output.append(re.sub(r"\x1b\[[0-9;]*m", "", line))
        if address := re.search(r"web-viewer at (http://127\.0\.0\.1:\d+)", output[-1]):
            opener = build_opener(ProxyHandler({}))  # a proxy of the environment is not for loopback
            try:
                return {name: opener.open(f"{address[1]}/{name}", timeout=PATIENCE).read() for name in FILES}
            except (URLError, HTTPException, OSError) as error:
                raise AssetsMissing(f"web viewer at {address[1]}: {error}") from error
    raise AssetsMissing(f"the rerun viewer did not start its web server: {''.join(output)[-2000:]}")


def _end(viewer: "subprocess.Popen[str]") -> None:
    """End the viewer and the interpreter that started it, which share a session."""
    with suppress(ProcessLookupError):
        os.killpg(viewer.pid, signal.SIGKILL)
    viewer.wait()
