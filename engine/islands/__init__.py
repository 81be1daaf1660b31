"""Connected components of a world: solved apart, and put to sleep."""
