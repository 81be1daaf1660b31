"""Joints: their rows, what acts along their coordinates, and how they are held."""
