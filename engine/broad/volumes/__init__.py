"""Bounding volumes tighter than the axis-aligned box: tests of the pairs it leaves, compiled only when a world uses them."""
