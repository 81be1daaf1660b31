"""Closed forms that more than one case is judged by, one motion a file."""
