"""Engines that load and have a version, and fail when they are asked to build; and a case that fails at its scene."""

import os
import signal
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from dying_version import Plain

from plumbline.harness.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Failing(Plain):
    """An engine that fails at building in one of several ways."""

    def build(self, scene: Scene, settings: Any) -> Any:
        if self.fault == "raises":
            raise LookupError("no licence")
        if self.fault == "exit":
            os._exit(0)
        if self.fault == "kill":
            os.kill(os.getpid(), signal.SIGSEGV)
        return None


LEAVES = Failing(name="leaves_build", fault="exit")
RAISES = Failing(name="raises_build", fault="raises")
NONE = Failing(name="none_build", fault="none")
KILLS = Failing(name="kills_build", fault="kill")
CASE = SimpleNamespace(name="leaves_scene", parameters={}, scene=lambda _: os._exit(0))
