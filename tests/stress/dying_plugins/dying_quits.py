"""A plug-in that asks the interpreter to end."""

import sys

sys.exit(0)
