"""Vectors, quaternions and matrices in registers, and numbers of two floats."""
