"""Sensing: rays, pictures, inertial sensors."""
