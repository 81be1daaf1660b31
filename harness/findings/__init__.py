"""What the records say: prices, limits, leads, readings of sensors, and the tables made of them."""
