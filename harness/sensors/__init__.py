"""Sensors: the ideal signal read off an engine's states and rays, and the noise laid over it; one sensor one file."""
