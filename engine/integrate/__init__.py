"""Integrators, one a file, for bodies that nothing touches; and the kick and drift of those that something does."""
