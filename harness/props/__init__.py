"""Parts that cases share: machines, and a scene with one of each regular motion."""
