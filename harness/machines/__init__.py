"""Robots in the scene's own words, one a file: bodies of real masses, driven hinges, and the points that they stand on."""
