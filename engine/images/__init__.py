"""Pictures of a world: a rasteriser, and a tracer of rays with shadows, reflection and refraction."""
