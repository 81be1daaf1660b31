"""Robot files read into scenes: URDF, MJCF and our own TOML and JSON, with what each element became said row by row.

`harness.scene.importers.reading.read(path, Wishes(...))` gives an `Imported`: scene, fidelity table, joints and links by name.
"""
