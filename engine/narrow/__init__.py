"""The narrow phase: the contact points of one pair of shapes, one file per kind of pair.

All functions of a pair are called alike: `sphere_box(a, b, margin, out, at)` writes the points of shapes A and B that are no
farther apart than the margin [m] into `out`, from row `row` on, and returns their number and the normal from A to B in W.
"""
