"""Cases: one question, one file, found by walking this folder; each ends in CASE."""
