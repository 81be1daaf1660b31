"""Known bugs and pitfalls of an engine, as scripts in the vendor's own API: read, run and prepared for a report upstream."""
