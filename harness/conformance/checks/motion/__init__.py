"""Free motion: frames, laws, single steps, digits."""
