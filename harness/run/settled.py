"""The last that a fork server loads: what stands in it by then is taken out of the search for garbage, which is made again.

Otherwise the first search of each process that comes off it would write to all of that memory, and so copy it.
"""

import gc

gc.collect()
gc.freeze()
gc.enable()
