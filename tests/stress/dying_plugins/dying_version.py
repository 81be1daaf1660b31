"""Adapters that load, and of which two fail when they are asked for their version."""

import os
from dataclasses import dataclass, field
from typing import Any

from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Plain(Adapter):
    """An engine that can do nothing."""

    title: str = "nothing"
    distribution: str = "dying"
    features: Feature = Feature.NONE
    tracks: dict[str, Settings] = field(default_factory=lambda: {"default": Settings(), "tuned": Settings()})
    fault: str = ""

    def version(self) -> str:
        if self.fault == "raise":
            raise KeyError("version")
        if self.fault == "leave":
            os._exit(0)
        return "1.0"

    def build(self, scene: Scene, settings: Settings) -> Any:
        raise Unsupported("everything", "it can do nothing")


ADAPTER = Plain(name="no_version", fault="raise")
ENDS = Plain(name="ends_at_version", fault="leave")
WELL = Plain(name="well")
