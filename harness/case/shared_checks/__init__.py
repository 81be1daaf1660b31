"""Bounds that more than one case is judged by, each derived once."""
