"""Reports: records in; HTML pages, charts and rerun recordings out."""
