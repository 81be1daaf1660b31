"""One trial in this process: its accuracy run, its ensemble, its truth, and what the clock runs of it."""
