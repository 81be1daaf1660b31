"""Broad phases: each finds the same pairs of shapes in the same order, and each is compiled only when a world uses it."""
