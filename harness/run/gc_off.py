"""`gc.disable()`: the first module that a fork server loads; `harness.run.gc_freeze` is its last.

What modules are made of stays as long as they do; each search meanwhile would walk all that was loaded before.
"""

import gc

gc.disable()
