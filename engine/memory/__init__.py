"""The memory of a world: two arrays, carved into tables."""
