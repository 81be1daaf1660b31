"""The one boundary between the harness and an engine."""

from plumbline.harness.adapter.contract import (
    Adapter,
    Diverged,
    Emulation,
    Feature,
    Unavailable,
    Unsupported,
)
from plumbline.harness.adapter.notice import Notice
from plumbline.harness.adapter.settings import Settings, SettingsError
from plumbline.harness.adapter.simulation import Simulation
from plumbline.harness.adapter.trade_off import Advantage, Extra, TradeOff

__all__ = [
    "Adapter",
    "Advantage",
    "Diverged",
    "Emulation",
    "Extra",
    "Feature",
    "Notice",
    "Settings",
    "SettingsError",
    "Simulation",
    "TradeOff",
    "Unavailable",
    "Unsupported",
]
