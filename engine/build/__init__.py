"""From what was told to a world's memory: solids, polyhedra, frames and orders that are found once."""
