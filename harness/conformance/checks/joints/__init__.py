"""Joints: what they hold, and what acts along their coordinates."""
