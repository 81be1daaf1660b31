"""A metric: one number read off a trajectory, with its unit and its source."""

from plumbline.harness.metric.metric import Metric, NotMeasurable, Run, metric

__all__ = ["Metric", "NotMeasurable", "Run", "metric"]
