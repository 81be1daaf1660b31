"""Robots in the scene's own words, one a file, with the points that they stand on; and what they and heaps stand in."""
