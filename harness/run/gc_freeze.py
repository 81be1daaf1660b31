"""`gc.freeze()` and then `gc.enable()`: the last module that a fork server loads.

Otherwise the first search of each process that comes off it would write to all of that memory, and so copy it.
"""

import gc

gc.collect()
gc.freeze()
gc.enable()
