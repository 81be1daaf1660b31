"""Compiling: Numba, a cache that serves no code of other sources, and what is done before the first function."""
