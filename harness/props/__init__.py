"""Parts that cases share: robots, and a scene with one of each regular motion."""
