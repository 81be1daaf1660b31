"""What is asked of an engine, by subject; the list of all stands in `harness.conformance.catalogue`."""
