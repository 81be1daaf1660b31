"""Marks of tests that ask an engine which not every Python has."""

import importlib.util

import pytest

BULLET = pytest.mark.skipif(
    importlib.util.find_spec("pybullet") is None, reason="pybullet publishes wheels for Python 3.10 and 3.11 only"
)
