"""Metrics, one quantity one file; each file ends in METRIC, a metric or a tuple of metrics of that quantity."""
