"""Charts as Vega-Lite specifications, and the look that all of them share."""
