"""Plumbline: cross-engine validation and benchmarking of rigid-body physics.

In a checkout, its packages are links to the folders of the same names at the top; installed, they are folders in here.
"""
