"""Records in; HTML pages, charts and recordings out. Reports never run physics and never call a metric."""
