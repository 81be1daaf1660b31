"""Where engines end in a scene without a truth: each against itself, then against each other, then what stays defined
beyond."""
