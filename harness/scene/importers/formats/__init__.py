"""One format of robot files, one file, ending in `IMPORTER`; a file that is put here is found by its presence."""
