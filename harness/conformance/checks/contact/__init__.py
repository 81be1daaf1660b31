"""Contact: geometry, forces, friction."""
