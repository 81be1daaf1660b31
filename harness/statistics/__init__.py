"""Numbers only: fronts, orders of convergence, ratios and proportions, each with its bounds."""
