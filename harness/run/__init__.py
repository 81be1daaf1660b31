"""A study over processes: accuracy runs in isolation, timing runs in blocks, and a folder that a kill does not hurt."""
