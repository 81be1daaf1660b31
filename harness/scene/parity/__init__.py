"""Are two descriptions the same robot? Facts of each in one frame, differences with tolerance, and what each is worth.

`harness.scene.parity.comparison.compare(facts_A, facts_B)` gives rows; `harness.scene.parity.stated.facts_of(path, wishes)` the
facts of a file.
"""
