"""Trees of joints in joint coordinates: no constraint is solved, since the coordinates leave no other motion."""
