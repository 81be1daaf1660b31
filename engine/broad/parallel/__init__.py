"""The broad phases with their searches shared out among threads, each compiled only when a world uses it."""
