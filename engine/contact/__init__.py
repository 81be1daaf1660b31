"""Where bodies touch: manifolds, made anew, matched and kept."""
