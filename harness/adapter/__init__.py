"""The one boundary between the harness and an engine."""

from harness.adapter.contract import (
    Adapter,
    Advantage,
    Diverged,
    Emulation,
    Feature,
    Settings,
    SettingsError,
    Simulation,
    Unavailable,
    Unsupported,
)

__all__ = [
    "Adapter",
    "Advantage",
    "Diverged",
    "Emulation",
    "Feature",
    "Settings",
    "SettingsError",
    "Simulation",
    "Unavailable",
    "Unsupported",
]
