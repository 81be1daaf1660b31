"""Metrics, one quantity one file, each a function below `@metric`."""
