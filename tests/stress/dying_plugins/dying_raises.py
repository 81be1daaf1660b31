"""A plug-in that cannot be imported, and says why in colour."""

raise RuntimeError("no licence \x1b[31mfound")
