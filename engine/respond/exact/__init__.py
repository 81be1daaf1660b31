"""The exact contact solver: Signorini's condition and Coulomb's cone solved to round-off, with a certificate for every step."""
