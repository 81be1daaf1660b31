"""Pages that stand alone: a history, a comparison of runs, a comparison of robots."""
