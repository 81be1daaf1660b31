"""The first hit of each ray: in tiles, through trees, and one after the other as the oracle of both."""
