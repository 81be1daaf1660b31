"""For print: the charts of a case, and the report as one PDF."""
