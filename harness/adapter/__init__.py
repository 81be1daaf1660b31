"""The one boundary between the harness and an engine."""

from harness.adapter.advantage import Advantage
from harness.adapter.contract import (
    Adapter,
    Diverged,
    Emulation,
    Feature,
    Unavailable,
    Unsupported,
)
from harness.adapter.notice import Notice
from harness.adapter.settings import Settings, SettingsError
from harness.adapter.simulation import Simulation
from harness.adapter.trade_off import TradeOff

__all__ = [
    "Adapter",
    "Advantage",
    "Diverged",
    "Emulation",
    "Feature",
    "Notice",
    "Settings",
    "SettingsError",
    "Simulation",
    "TradeOff",
    "Unavailable",
    "Unsupported",
]
