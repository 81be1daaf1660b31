"""The first that a fork server loads: until `harness.run.gc_freeze`, its last, nothing is searched for garbage.

What modules are made of stays as long as they do; each search meanwhile would walk all that was loaded before.
"""

import gc

gc.disable()
