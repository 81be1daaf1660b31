"""What sensors read, as a run folder keeps it: against the truth and against the law of its noise; one subject one file."""
