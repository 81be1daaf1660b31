"""The contract itself: what is declared, claimed, refused, kept and repeated."""
