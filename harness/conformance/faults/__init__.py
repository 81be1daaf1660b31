"""Planted faults: engines broken in exactly one way each, and what has to catch them."""
