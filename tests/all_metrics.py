"""Every metric of the house by name, for tests that hold all of them to one rule."""

import importlib
import pkgutil

import plumbline.harness.metrics
from plumbline.harness.metric import Metric


def all_metrics() -> dict[str, Metric]:
    """Of every file in harness/metrics."""
    by_name: dict[str, Metric] = {}
    for module in pkgutil.iter_modules(plumbline.harness.metrics.__path__, "plumbline.harness.metrics."):
        for value in vars(importlib.import_module(module.name)).values():
            for metric in value.values() if isinstance(value, dict) else (value,):
                if isinstance(metric, Metric):
                    assert by_name.setdefault(metric.name, metric) is metric, f"{metric.name}: two metrics have this name"
    return by_name
