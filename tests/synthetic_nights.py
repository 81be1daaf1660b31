"""Histories of nights, made of formulas: several series on one machine, with noise, outliers and slow nights."""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.trajectory import Floats

__all__ = ["NIGHTS", "History", "history"]

NIGHTS = 60
NOISE = 0.02


@dataclass(frozen=True)
class History:
    """Terms: prices (s, n) [s]; canary (n,) [s], clocked beside them."""

    prices: Floats
    canary: Floats


def history(seed: tuple[int, ...], series: int = 20, changed: int = 1, factor: Floats | None = None) -> History:
    """Noise of 2 % on every price, 3 % outliers up to 1.5 times as long, a tenth of the nights slow for all, up to 1.6 times,
    and a machine that wanders by 1 %; the first `changed` series are multiplied by `factor` (n,)."""
    rng = np.random.default_rng(seed)
    level = 1e-3 * np.exp(rng.normal(0, 1, (series, 1)))
    slow = np.where(rng.random(NIGHTS) < 0.1, rng.uniform(1.05, 1.6, NIGHTS), 1.0) * np.exp(rng.normal(0, 0.01, NIGHTS))
    outliers = np.where(rng.random((series, NIGHTS)) < 0.03, rng.uniform(1.1, 1.5, (series, NIGHTS)), 1.0)
    prices = level * slow * outliers * np.exp(rng.normal(0, NOISE, (series, NIGHTS)))
    if factor is not None:
        prices[:changed] *= factor
    return History(prices=prices, canary=1e-3 * slow * np.exp(rng.normal(0, 0.01, NIGHTS)))
