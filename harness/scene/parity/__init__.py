"""Are two descriptions the same robot? Both in one canonical form, differences with tolerance, and what each is worth.

`harness.scene.parity.comparison.compare(a, b)` gives rows; `harness.scene.parity.canonical.stated(path, wishes)` the robot of a
file.
"""
