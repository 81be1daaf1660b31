"""Swept continuous collision, linear and angular: the world is stopped at each impact of a step, and goes on from there."""
