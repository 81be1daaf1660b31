"""Metrics, one subject one file, each a function below `@metric`."""
