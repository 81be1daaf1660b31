"""Adapters that can be loaded and are not what an adapter is."""

from dataclasses import dataclass, field
from typing import Any

from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Odd(Adapter):
    """An adapter with one odd field or version."""

    title: Any = "odd"
    distribution: str = "dying"
    features: Any = Feature.NONE
    tracks: Any = field(default_factory=lambda: {"default": Settings(), "tuned": Settings()})
    says: Any = "1.0"

    def version(self) -> Any:
        return self.says

    def build(self, scene: Scene, settings: Settings) -> Any:
        raise Unsupported("scenes", "it only tells its version")


VERSION_NONE = Odd(name="version_none", says=None)
VERSION_NUMBER = Odd(name="version_number", says=3)
VERSION_BYTES = Odd(name="version_bytes", says=b"1.0")
VERSION_COLOUR = Odd(name="version_colour", says="\x1b[31m1.0")
VERSION_LONG = Odd(name="version_long", says="1" * 2**20)
VERSION_EMPTY = Odd(name="version_empty", says="")
TITLE_NUMBER = Odd(name="title_number", title=5)
FEATURES_NUMBER = Odd(name="features_number", features=3)
TRACKS_NONE = Odd(name="tracks_none", tracks=None)
TRACKS_ONE = Odd(name="tracks_one", tracks={"default": Settings()})
TRACKS_TEXT = Odd(name="tracks_text", tracks={"default": "fast", "tuned": "good"})
NAME_OTHER = Odd(name="another_name")
NO_ADAPTER = 5
