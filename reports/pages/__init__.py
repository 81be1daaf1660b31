"""Pages of the report: one page, one file, found by walking this folder; each ends in PAGE."""
