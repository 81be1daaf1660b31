"""The narrow phase: the contact points of one pair of shapes, one file per kind of pair.

Every function takes the poses in W and writes points through `put_point`: place, normal from A to B, gap, feature.
"""
