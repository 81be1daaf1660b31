"""What is wrong or a trap in an engine, as scripts in the vendor's own API: read, run and made ready for a report upstream."""
