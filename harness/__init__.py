"""The vocabulary of a comparison (scene, trajectory, adapter, case, metric, study, record) and the machinery that runs it."""
