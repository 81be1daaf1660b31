"""The Python interface: what `plumbline.__all__` lists, and what the command line shares with it."""
